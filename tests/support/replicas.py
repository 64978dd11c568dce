"""Processes of the service that tests may kill, each on a listening socket that outlives it."""

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import httpx2

from tests.support.waiting import wait_for

START_SECONDS = 120.0
STOP_SECONDS = 30.0


class Replica:
    """Process of the service that can be killed and started again.

    The test keeps the listening socket: while the process is down, connections wait for the next one, so that no
    client has to poll.
    """

    def __init__(
        self, database_url: str, log: Path, *options: str, environment: Mapping[str, str] | None = None
    ) -> None:
        self.database_url = database_url
        self.log = log
        self._options = options
        self._environment = environment
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self.url = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def pid(self) -> int:
        """Process id of the running process."""
        assert self._process is not None
        return self._process.pid

    def start(self) -> None:
        """Start the process and wait until it is ready."""
        self.launch()
        self.wait_until_ready()

    def launch(self) -> None:
        """Start the process without waiting."""
        options = [*self._address(), "--database-url", self.database_url, *self._options]
        command = [sys.executable, "-m", "voa_service", *options]
        inherited = [] if self._listening.fileno() < 0 else [self._listening.fileno()]
        with self.log.open("ab") as stderr:
            self._process = subprocess.Popen(command, stderr=stderr, pass_fds=inherited, env=self._environment)

    def _address(self) -> list[str]:
        """Return the options that say where to listen."""
        return ["--fd", str(self._listening.fileno())]

    def wait_until_ready(self) -> None:
        """Wait until the process and its database respond."""
        httpx2.get(f"{self.url}/readyz", timeout=START_SECONDS).raise_for_status()

    @property
    def zenoh(self) -> str:
        """State of the connection to a Zenoh router: "off", "connecting" or "connected"."""
        health = httpx2.get(f"{self.url}/readyz", timeout=START_SECONDS).raise_for_status().json()
        return str(health["zenoh"])

    def kill(self) -> None:
        """Kill the process by SIGKILL and wait for its end."""
        self.signal(signal.SIGKILL)
        self.wait()

    def signal(self, which: signal.Signals) -> None:
        """Send a signal to the process without waiting."""
        assert self._process is not None
        self._process.send_signal(which)

    def wait(self) -> int:
        """Wait for the end of the process and return its exit code."""
        assert self._process is not None
        return self._process.wait(STOP_SECONDS)

    def end(self) -> None:
        """Kill the process if it runs, and close the socket."""
        if self._process is not None and self._process.poll() is None:
            self.kill()
        self._listening.close()


class Listener(Replica):
    """Process of the service that opens its own socket: while it is down, connections are refused, as in production."""

    def __init__(
        self, database_url: str, log: Path, *options: str, environment: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(database_url, log, *options, environment=environment)
        self._port = self._listening.getsockname()[1]
        self._listening.close()

    def _address(self) -> list[str]:
        return ["--port", str(self._port)]

    def wait_until_ready(self) -> None:
        """Wait until the process listens, and its database responds."""
        wait_for(self._listens, f"a service at {self.url}", START_SECONDS)
        super().wait_until_ready()

    def _listens(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, self.log.read_text()
        try:
            socket.create_connection(("127.0.0.1", self._port)).close()
        except OSError:
            return False
        return True


@contextmanager
def replicas(
    database_url: str,
    folder: Path,
    count: int = 1,
    *options: str,
    environment: Mapping[str, str] | None = None,
    kind: type[Replica] = Replica,
) -> Iterator[list[Replica]]:
    """Run `count` processes of the service on one database, with the test's own environment where none is given."""
    with ExitStack() as stack:
        own = [
            kind(database_url, folder / f"service-{number}.log", *options, environment=environment)
            for number in range(count)
        ]
        for replica in own:
            stack.callback(replica.end)
            replica.launch()
        for replica in own:
            replica.wait_until_ready()
        yield own
