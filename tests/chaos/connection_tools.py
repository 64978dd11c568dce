"""A service in a process of its own, and connections that are opened by hand."""

import os
import resource
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import httpx2

START_SECONDS = 60.0
ANSWER_SECONDS = 5.0


@dataclass
class Server:
    """A running service.

    Attributes:
        process: what runs it.
        port: of 127.0.0.1.
        log: what it wrote to stderr.
    """

    process: subprocess.Popen[bytes]
    port: int
    log: Path
    _sockets: list[socket.socket] = field(default_factory=list)

    @property
    def url(self) -> str:
        """Give the address of the service."""
        return f"http://127.0.0.1:{self.port}"

    def connect(self) -> socket.socket:
        """Open a connection, closed when the attack ends."""
        opened = socket.create_connection(("127.0.0.1", self.port), timeout=ANSWER_SECONDS)
        self._sockets.append(opened)
        return opened

    def close(self) -> None:
        """Close every connection."""
        for each in self._sockets:
            each.close()

    def memory(self, name: str = "VmRSS") -> float:
        """Read a figure of the process's memory, in MB; `VmHWM` is the most that it had."""
        for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith(name):
                return int(line.split()[1]) / 1e3
        raise RuntimeError(f"the service is gone: {self.log.read_text()[-2_000:]}")

    def answers(self, path: str = "/livez", seconds: float = ANSWER_SECONDS) -> float | None:
        """Time a GET on a new connection, in seconds; None: no answer in `seconds`, or another than 200."""
        began = time.monotonic()
        with suppress(httpx2.HTTPError):
            if httpx2.get(self.url + path, timeout=seconds).status_code == 200:
                return time.monotonic() - began
        return None

    def stop(self, seconds: float) -> float | None:
        """Send SIGTERM; time until the end in seconds, None where it did not end within `seconds`."""
        began = time.monotonic()
        self.process.terminate()
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None
        return time.monotonic() - began


@contextmanager
def server(folder: Path, files: int = 4_096, **environment: str) -> Iterator[Server]:
    """Run `voa serve` on a free port of 127.0.0.1 for the length of a `with`.

    Args:
        folder: for its database and its log.
        files: how many files it may have open at once.
        environment: its settings, `VOA_...`.
    """
    log = folder / "service.log"
    with socket.create_server(("127.0.0.1", 0), backlog=2_048) as listening, log.open("wb") as stderr:
        port = listening.getsockname()[1]
        process = subprocess.Popen(
            [sys.executable, "-m", "voa_service", "--fd", str(listening.fileno())],
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            pass_fds=[listening.fileno()],
            env=os.environ | {"VOA_DATABASE_URL": f"sqlite:///{folder / 'voa.db'}"} | environment,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files)),  # noqa: PLW1509 - no threads yet
        )
    running = Server(process, port, log)
    try:
        httpx2.get(running.url + "/readyz", timeout=START_SECONDS).raise_for_status()
        yield running
    finally:
        running.close()
        process.kill()
        process.wait()


def head(method: str, path: str, *headers: str) -> bytes:
    """Write the beginning of a request, with the empty line that ends its headers."""
    return "\r\n".join([f"{method} {path} HTTP/1.1", "Host: 127.0.0.1", *headers, "", ""]).encode()


def posting(length: int) -> bytes:
    """Write the headers of a scenario of so many bytes."""
    return head("POST", "/v1/scenarios", "Content-Type: application/json", f"Content-Length: {length}")


def status(opened: socket.socket, seconds: float) -> str:
    """Read the status of an answer: "431", "closed" where the connection ended without one, "none" where none came."""
    opened.settimeout(seconds)
    try:
        first = opened.recv(65_536)
    except TimeoutError:
        return "none"
    except OSError:
        return "closed"
    return first.split(b" ", 2)[1].decode() if first.startswith(b"HTTP/1.1 ") else "closed"


def together(jobs: list[Callable[[], None]]) -> None:
    """Run jobs in a thread each, and wait for all."""
    threads = [threading.Thread(target=job) for job in jobs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
