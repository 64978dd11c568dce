"""Services that are started on this machine for the length of a `with`, and the end of any child process."""

import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2

from voa_client import Client, Retries, VoaClientError

_START_SECONDS = 60.0
_STOP_SECONDS = 20.0
_LOG_LINES = 15
BRIEFLY = Retries(within_s=2.0)
"""Retries for a person at a terminal: enough for a short disturbance, and a wrong address is soon reported."""


class ServiceDidNotStart(VoaClientError):
    """A service that was started ended early, or did not answer in time."""


class Running(NamedTuple):
    """A server process that is ready: its URL and process id."""

    url: str
    pid: int


@contextmanager
def running(module: str, options: Sequence[str], log: Path, ready: str = "/readyz") -> Iterator[Running]:
    """Start `python -m MODULE --fd N OPTIONS` on a free port of 127.0.0.1 and stop it on leaving.

    The socket is opened here and passed to the process, so that the port is known, and the first request waits for the
    server instead of failing.

    Args:
        module: to run.
        options: for its command line, besides `--fd`.
        log: file for its stderr.
        ready: path that it answers when it is ready.

    Raises:
        ServiceDidNotStart: the process ended, or did not answer within 60 s.
    """
    with socket.create_server(("127.0.0.1", 0)) as listening, log.open("wb") as stderr:
        url = f"http://127.0.0.1:{listening.getsockname()[1]}"
        command = [sys.executable, "-m", module, "--fd", str(listening.fileno()), *options]
        # Not our stdout: a reader of our output would wait for the end of this process, too.
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr, pass_fds=[listening.fileno()])  # noqa: S603 - our own module
    try:
        try:
            httpx2.get(url + ready, timeout=_START_SECONDS).raise_for_status()
        except httpx2.HTTPError as error:
            raise ServiceDidNotStart(f"{module} did not start ({error}):\n{_tail(log)}") from error
        yield Running(url, process.pid)
    finally:
        end(process, _STOP_SECONDS)


def end(process: "subprocess.Popen[bytes]", patience_s: float) -> None:
    """Terminate a child process and wait for its end; it is killed where it has not ended after `patience_s` seconds.

    A process that has ended already keeps its exit status. Its pipes, if it has any, stay open.
    """
    process.terminate()
    try:
        process.wait(patience_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@contextmanager
def local_service(folder: Path | None = None, database: str = "voa.db") -> Iterator[str]:
    """Run `voa serve` on SQLite for the length of a `with`; gives its URL.

    Args:
        folder: for its database and log; None: a temporary folder.
        database: name of the file in that folder.

    Raises:
        ServiceDidNotStart: the service ended, or did not answer within 60 s.
    """
    with tempfile.TemporaryDirectory(prefix="voa-") as temporary:
        place = Path(temporary) if folder is None else folder
        place.mkdir(parents=True, exist_ok=True)
        url = f"sqlite:///{(place / database).resolve()}"
        with running("voa_service", ["--database-url", url], place / "service.log") as service:
            yield service.url


def _tail(log: Path) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-_LOG_LINES:])


@contextmanager
def service_at(url: str | None) -> Iterator[Client]:
    """Open a client of the service at `url`; None: of a service that is started for the length of the `with`."""
    if url is not None:
        with Client(url, retries=BRIEFLY) as client:
            yield client
        return
    with local_service() as own, Client(own) as client:
        yield client
