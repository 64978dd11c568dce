"""HAProxy in front of replicas, with the configuration that laboratories get, on ports of this machine."""

import csv
import io
import re
import shutil
import socket
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.support.waiting import wait_for

CONFIGURATION = Path(__file__).parents[2] / "deploy/haproxy.cfg"
_PROBES = "inter 2s fall 2 rise 2"
_QUICK_PROBES = "inter 100ms fall 2 rise 2"
_NAMES = "resolvers containers init-addr libc,none"
_PROBE_TIMEOUT = "10s"
"""Time for the response to a quick probe; without it the response would have to come before the next probe."""
_START_SECONDS = 10.0
_STOP_SECONDS = 10.0


class Balancer:
    """HAProxy that runs.

    Args:
        url: at which it answers by HTTP.
        pid: of its process.
        status: its socket for commands.
    """

    def __init__(self, url: str, pid: int, status: Path) -> None:
        self.url = url
        self.pid = pid
        self._status = status

    def states(self) -> dict[str, str]:
        """Return the state of each replica, such as "UP" or "DOWN", by the name of its server."""
        rows = csv.DictReader(io.StringIO(self._command("show stat").removeprefix("# ")))
        return {row["svname"]: row["status"] for row in rows if row["svname"].startswith("voa-")}

    def retries(self) -> int:
        """Return the number of requests that were sent to a replica again, or to another one."""
        rows = csv.DictReader(io.StringIO(self._command("show stat").removeprefix("# ")))
        return sum(int(row["wretr"]) + int(row["wredis"]) for row in rows if row["svname"] == "BACKEND")

    def _command(self, command: str) -> str:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(self._status))
            connection.sendall(f"{command}\n".encode())
            return connection.makefile().read()


@contextmanager
def balancer(replicas: Sequence[str], folder: Path, *, quick: bool = False) -> Iterator[Balancer]:
    """Run HAProxy in front of replicas.

    Args:
        replicas: URLs.
        folder: for the configuration, the log and the socket for commands.
        quick: probe each replica ten times a second, and not every two seconds.
    """
    program = shutil.which("haproxy") or shutil.which("haproxy", path="/usr/sbin")
    assert program is not None, "HAProxy is missing; on Debian: apt-get install haproxy"
    status, file = folder / "haproxy.sock", folder / "haproxy.cfg"
    with socket.create_server(("127.0.0.1", 0), backlog=1024) as listening:
        text = adapted(CONFIGURATION.read_text(encoding="utf-8"), listening.fileno(), replicas, status, quick=quick)
        file.write_text(text, encoding="utf-8")
        with (folder / "haproxy.log").open("ab") as log:
            command = [program, "-db", "-f", str(file)]
            process = subprocess.Popen(command, stdout=log, stderr=log, pass_fds=[listening.fileno()])
        try:
            wait_for(lambda: status.exists() or process.poll() is not None, "HAProxy", _START_SECONDS)
            assert process.poll() is None, (folder / "haproxy.log").read_text()
            yield Balancer(f"http://127.0.0.1:{listening.getsockname()[1]}", process.pid, status)
        finally:
            process.terminate()
            process.wait(_STOP_SECONDS)


def adapted(text: str, listening: int, replicas: Sequence[str], status: Path, *, quick: bool = False) -> str:
    """Return the configuration with the addresses of a test, without TLS and names of containers.

    What decides which replica gets a request, and whether it is sent again, stays as it is.
    """
    head, frontend, backend = (_section(text, name) for name in ("global", "frontend voa", "backend replicas"))
    assert _PROBES in backend
    assert _NAMES in backend
    probed = backend.replace(_NAMES, "").replace(_PROBES, _QUICK_PROBES if quick else _PROBES)
    kept = [line for line in probed.splitlines() if not re.match(r"\s+server ", line)]
    servers = [f"  server voa-{n} {url.removeprefix('http://')}" for n, url in enumerate(replicas, 1)]
    return "\n".join(
        [
            re.sub(r"(?m)^\s+ssl-default.*\n", "", head),
            f"  stats socket {status}",
            _section(text, "defaults") + (f"\n  timeout check {_PROBE_TIMEOUT}" if quick else ""),
            re.sub(r"(?m)^\s+bind .*$", f"  bind fd@{listening}", frontend),
            *kept,
            *servers,
            "",
        ]
    )


def _section(text: str, name: str) -> str:
    """Return one section of a configuration, without its comments."""
    match = re.search(rf"(?m)^{re.escape(name)}\n((?:[ \t#].*\n|\n)*)", text)
    assert match is not None, f"deploy/haproxy.cfg has no section {name!r}"
    lines = [line for line in match[0].splitlines() if line.strip() and not line.lstrip().startswith("#")]
    return "\n".join(lines)
