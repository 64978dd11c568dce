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

DEBIAN_BINARIES = Path("/usr/lib/postgresql")
HOW_TO_INSTALL = "PostgreSQL's server is not installed; on Debian: apt-get install postgresql"


def binaries() -> Path:
    """The folder of `initdb` and `postgres`, the newest where there are several.

    Raises:
        FileNotFoundError: the server is not installed; says how to.
    """
    found = sorted(DEBIAN_BINARIES.glob("*/bin"), key=lambda path: float(path.parent.name))
    on_path = shutil.which("initdb")
    if not found and on_path is None:
        raise FileNotFoundError(HOW_TO_INSTALL)
    return found[-1] if found else Path(str(on_path)).parent


@contextmanager
def cluster() -> Iterator[str]:
    """The URL of a database on a cluster of our own, which goes away afterwards."""
    where = binaries()
    with tempfile.TemporaryDirectory(prefix="voa-pg-") as folder:
        home = Path(folder)
        as_whom: dict[str, Any] = {}
        if os.geteuid() == 0:  # initdb refuses root
            owner = pwd.getpwnam("postgres")
            os.chown(home, owner.pw_uid, owner.pw_gid)
            as_whom = {"user": owner.pw_uid, "group": owner.pw_gid, "extra_groups": []}
        data = home / "data"
        port = _free_port()
        options = f"-c port={port} -c listen_addresses=127.0.0.1 -c unix_socket_directories={home} -c fsync=off"
        control = [str(where / "pg_ctl"), "-D", str(data), "-w", "-l", str(home / "log")]

        def run(*command: str) -> None:
            subprocess.run(command, check=True, capture_output=True, cwd=home, **as_whom)

        run(str(where / "initdb"), "-N", "-A", "trust", "-U", "voa", "-E", "UTF8", "-D", str(data))
        run(*control, "-o", options, "start")
        try:
            yield f"postgresql://voa@127.0.0.1:{port}/postgres"
        finally:
            run(*control, "-m", "immediate", "stop")


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port: int = listening.getsockname()[1]
        return port
