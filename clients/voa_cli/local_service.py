"""A service of one's own for the length of a command."""

import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from voa_client import Client, VoaClientError

_STOP_SECONDS = 20
_LOG_LINES = 15


class ServiceDidNotStart(VoaClientError):
    """The service ended, or did not answer."""


@contextmanager
def local_service(folder: Path | None = None) -> Iterator[str]:
    """Start `voa serve` on a free port of 127.0.0.1 and stop it on leaving; gives its URL.

    The socket is opened here and handed over, so the port is known and the first request waits for the service
    instead of failing.

    Args:
        folder: where its database and log go; None: a temporary folder.
    """
    with tempfile.TemporaryDirectory(prefix="voa-") as temporary:
        place = Path(temporary) if folder is None else folder
        place.mkdir(parents=True, exist_ok=True)
        log = place / "service.log"
        with socket.create_server(("127.0.0.1", 0)) as listening, log.open("wb") as stderr:
            url = f"http://127.0.0.1:{listening.getsockname()[1]}"
            command = [sys.executable, "-m", "voa_service", "--fd", str(listening.fileno())]
            command += ["--database-url", f"sqlite:///{(place / 'voa.db').resolve()}"]
            process = subprocess.Popen(command, stderr=stderr, pass_fds=[listening.fileno()])  # noqa: S603 - ours
        try:
            try:
                with Client(url) as client:
                    client.ready()
            except VoaClientError as error:
                raise ServiceDidNotStart(f"the service did not start ({error}):\n{_tail(log)}") from error
            yield url
        finally:
            process.terminate()
            try:
                process.wait(_STOP_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _tail(log: Path) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-_LOG_LINES:])


@contextmanager
def service_at(url: str | None) -> Iterator[Client]:
    """A client of the service at `url`, or of one that is started for the purpose."""
    if url is not None:
        with Client(url) as client:
            yield client
        return
    with local_service() as own, Client(own) as client:
        yield client
