"""A real PostgreSQL for the length of a test run: its own cluster, on a free port of 127.0.0.1."""

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psycopg

DEBIAN_BINARIES = Path("/usr/lib/postgresql")
HOW_TO_INSTALL = "PostgreSQL's server is not installed; on Debian: apt-get install postgresql"


def binaries() -> Path:
    """Return the folder of `initdb` and `postgres`, the newest where there are several.

    Raises:
        FileNotFoundError: the server is not installed; the error says how to install it.
    """
    folders = sorted(DEBIAN_BINARIES.glob("*/bin"), key=lambda path: float(path.parent.name))
    on_path = shutil.which("initdb")
    if not folders and on_path is None:
        raise FileNotFoundError(HOW_TO_INSTALL)
    return folders[-1] if folders else Path(str(on_path)).parent


class Server:
    """PostgreSQL cluster of a test, which can be stopped and started, and creates databases."""

    def __init__(self, home: Path, durable: bool = False) -> None:
        self._fsync = "on" if durable else "off"
        self._binaries = binaries()
        self._home = home
        self._as_whom: dict[str, Any] = {}
        if os.geteuid() == 0:  # initdb refuses root
            owner = pwd.getpwnam("postgres")
            os.chown(home, owner.pw_uid, owner.pw_gid)
            self._as_whom = {"user": owner.pw_uid, "group": owner.pw_gid, "extra_groups": []}
        self._port = _free_port()
        self._made = 0
        self._run("initdb", "-N", "-A", "trust", "-U", "voa", "-E", "UTF8")

    def url(self, database: str = "postgres") -> str:
        """The URL of one database."""
        return f"postgresql://voa@127.0.0.1:{self._port}/{database}"

    @property
    def pids(self) -> list[int]:
        """Process ids of the server; the first process is last in the list, because it would restart the others."""
        first = int((self._home / "data" / "postmaster.pid").read_text().split()[0])
        children = Path(f"/proc/{first}/task/{first}/children").read_text().split()
        return [*map(int, children), first]

    def start(self) -> None:
        """Start the server and wait until it responds."""
        address = f"-c port={self._port} -c listen_addresses=127.0.0.1 -c unix_socket_directories={self._home}"
        self._run("pg_ctl", "-w", "-l", self._home / "log", "-o", f"{address} -c fsync={self._fsync}", "start")

    def stop(self) -> None:
        """Close every connection and stop; committed data is kept."""
        self._run("pg_ctl", "-w", "-m", "fast", "stop")

    def end(self) -> None:
        """Stop at once, without saving data."""
        self._run("pg_ctl", "-m", "immediate", "stop")

    def new_database(self) -> str:
        """Create an empty database and return its URL."""
        self._made += 1
        name = f"voa_{self._made}"
        with psycopg.connect(self.url(), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}")
        return self.url(name)

    def _run(self, program: str, *arguments: str | Path) -> None:
        command = [self._binaries / program, "-D", self._home / "data", *arguments]
        subprocess.run(command, check=True, capture_output=True, cwd=self._home, **self._as_whom)


@contextmanager
def server(*, durable: bool = False) -> Iterator[Server]:
    """Run a cluster and remove it afterwards; `durable` syncs every commit to disk, as in production."""
    with tempfile.TemporaryDirectory(prefix="voa-pg-") as folder:
        own = Server(Path(folder), durable)
        own.start()
        try:
            yield own
        finally:
            own.end()


@contextmanager
def cluster() -> Iterator[str]:
    """Run a cluster, yield the URL of its database, and remove the cluster afterwards."""
    with server() as own:
        yield own.url()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port: int = listening.getsockname()[1]
        return port
