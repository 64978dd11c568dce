"""A console as a process: listens on an address until a signal stops it."""

import signal
import socket
import sys
from collections.abc import Callable

import uvicorn

from voa_console.application import create
from voa_console.settings import ConsoleSettings

_STOP_SECONDS = 2
"""Seconds for which open pages are waited for when the process stops; their browsers reconnect by themselves."""


def listen(settings: ConsoleSettings) -> socket.socket:
    """Open the socket of a console; raises OSError if the address cannot be used."""
    family, kind, protocol, _, address = socket.getaddrinfo(
        settings.host, settings.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listening = socket.socket(family, kind, protocol)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind(address)
    except OSError:
        listening.close()
        raise
    return listening


def address_of(listening: socket.socket) -> str:
    """Return the URL at which a browser opens the console that listens on a socket."""
    host, port = listening.getsockname()[:2]
    if host in ("0.0.0.0", "::"):  # noqa: S104 - compared, not listened on
        host = "127.0.0.1"
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"


def serve(settings: ConsoleSettings, listening: socket.socket, ready: Callable[[], None]) -> None:
    """Serve a console on a socket until a signal stops the process.

    Args:
        settings: of the console.
        listening: socket of `listen`.
        ready: called when pages can be opened.
    """
    config = uvicorn.Config(
        create(settings),
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=_STOP_SECONDS,
    )
    # uvicorn raises the signal again when it has stopped, which by default would end the process at once.
    signal.signal(signal.SIGTERM, _leave)
    _Server(config, ready).run([listening])


def _leave(*_: object) -> None:
    """Exit in order at the first SIGTERM, and ignore further ones."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit(0)


class _Server(uvicorn.Server):
    """Server that reports when it accepts connections."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[], None]) -> None:
        super().__init__(config)
        self._ready = ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to accept connections, and report it."""
        await super().startup(sockets)
        self._ready()
