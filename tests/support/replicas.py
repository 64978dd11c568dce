"""`voa serve` as a process that tests may kill, on a socket that outlives it."""

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx2

START_SECONDS = 120.0
STOP_SECONDS = 30.0


class Replica:
    """One process of the service.

    The test keeps the listening socket: while the process is down, connections wait for the next one, so that
    nobody has to ask again and again whether it is back.
    """

    def __init__(self, database_url: str, log: Path, *options: str) -> None:
        self.database_url = database_url
        self.log = log
        self._options = options
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self.url = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def pid(self) -> int:
        """Of the process that runs."""
        assert self._process is not None
        return self._process.pid

    def start(self) -> None:
        """Returns when it is ready."""
        self.launch()
        self.wait_until_ready()

    def launch(self) -> None:
        """Returns at once."""
        options = ["--fd", str(self._listening.fileno()), "--database-url", self.database_url, *self._options]
        command = [sys.executable, "-m", "voa_service", *options]
        with self.log.open("ab") as stderr:
            self._process = subprocess.Popen(command, stderr=stderr, pass_fds=[self._listening.fileno()])

    def wait_until_ready(self) -> None:
        """It answers, and so does its database."""
        httpx2.get(f"{self.url}/readyz", timeout=START_SECONDS).raise_for_status()

    @property
    def zenoh(self) -> str:
        """Whether it is joined to a router: "off", "connecting" or "connected"."""
        health = httpx2.get(f"{self.url}/readyz", timeout=START_SECONDS).raise_for_status().json()
        return str(health["zenoh"])

    def kill(self) -> None:
        """Kill -9."""
        self.signal(signal.SIGKILL)
        self.wait()

    def signal(self, which: signal.Signals) -> None:
        """Send a signal and go on."""
        assert self._process is not None
        self._process.send_signal(which)

    def wait(self) -> int:
        """Its exit code."""
        assert self._process is not None
        return self._process.wait(STOP_SECONDS)

    def end(self) -> None:
        """Stop it if it runs."""
        if self._process is not None and self._process.poll() is None:
            self.kill()
        self._listening.close()


@contextmanager
def replicas(database_url: str, folder: Path, count: int = 1, *options: str) -> Iterator[list[Replica]]:
    """So many processes on one database."""
    with ExitStack() as stack:
        own = [Replica(database_url, folder / f"service-{number}.log", *options) for number in range(count)]
        for replica in own:
            stack.callback(replica.end)
            replica.launch()
        for replica in own:
            replica.wait_until_ready()
        yield own
