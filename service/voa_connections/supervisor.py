"""Supervision of all HTTP connections: bounds their number, closes idle ones, and ends those that make no progress."""

import asyncio
import socket
import ssl
from collections.abc import Callable
from functools import partial
from typing import Protocol

import structlog

from voa_connections import refusals
from voa_connections.connection import Connection, Stage
from voa_connections.handshake import Handshake
from voa_connections.in_flight import ByteBudget
from voa_connections.refusals import Refusal
from voa_connections.responses import Respond
from voa_connections.settings import MEBIBYTE, ConnectionSettings

RESERVED_FILES = 256
"""Files of the process that are kept for the database, Zenoh, mesh readers and followers, and not for connections."""
SPARE = 64
"""Connections beyond the limit on which health probes are answered and other requests refused."""
_IDLE = (Stage.SILENT, Stage.HEADERS, Stage.CLOSING)  # members of an Enum have a slow hash
_CHECK_SECONDS = 1.0
_QUIET_SECONDS = 60.0


def most_connections(settings: ConnectionSettings, files: int) -> int:
    """Return the number of connections allowed, from the settings and the number of files that the process may open."""
    return min(settings.most, max(files - RESERVED_FILES, files // 2))


class Supervised(Protocol):
    """A connection, with or without TLS, that may be ended."""

    stage: Stage
    is_probe: bool
    sent_at: float
    loop: asyncio.AbstractEventLoop

    @property
    def unsent(self) -> int:
        """Bytes of responses that the peer has not read yet."""
        ...

    def overdue(self, now: float) -> Refusal | None:
        """Return the reason to end the connection, or None."""
        ...

    def refuse(self, refusal: Refusal) -> None:
        """Refuse the request under way, and end the connection."""
        ...

    def close(self) -> None:
        """End the connection, which has no request under way."""
        ...


class ConnectionSupervisor:
    """Supervises connections, which its `protocol` makes.

    Args:
        settings: bounds on connections.
        files: number of files that the process may open (RLIMIT_NOFILE).
        respond: makes the response of a refusal.
        on_refusal: called with the reason of each refusal, for metrics.
    """

    def __init__(
        self,
        settings: ConnectionSettings,
        files: int,
        respond: Respond,
        on_refusal: Callable[[str], None],
    ) -> None:
        self._settings = settings
        self._on_refusal = on_refusal
        self.respond = respond
        self._most = most_connections(settings, files)
        self._unsent = settings.in_flight_mebibytes * MEBIBYTE
        self.budget = ByteBudget(self._unsent, self.count)
        self._open: set[Supervised] = set()
        self._idle: dict[Supervised, None] = {}  # without a request under way, the longest idle first
        self._probes: dict[Supervised, None] = {}  # beyond the limit, the oldest first
        self._seen: dict[str, float] = {}
        self._next_check: asyncio.TimerHandle | None = None
        self.is_draining = False
        """True where each response ends its connection, so that clients connect to another process."""
        self.too_many = refusals.too_many_connections(self._most)

    @property
    def connections(self) -> int:
        """Number of connections that are open."""
        return len(self._open)

    @property
    def protocol(self) -> Callable[..., Connection]:
        """Factory of the protocol of a connection, for uvicorn."""
        return partial(Connection, self, self._settings)

    def shake(self, accepted: socket.socket, context: ssl.SSLContext, connect: Callable[[], Connection]) -> None:
        """Begin the TLS handshake of a connection, whose protocol `connect` makes."""
        Handshake(self, self._settings.header_seconds, accepted, context, connect)

    def opened(self, connection: Supervised) -> None:
        """Register a new connection; where there are too many, close the one that has been idle the longest."""
        self._open.add(connection)
        if self._next_check is None:
            self._next_check = connection.loop.call_later(_CHECK_SECONDS, self.check, connection.loop)
        if len(self._open) - len(self._probes) <= self._most:
            self._idle[connection] = None
        elif self._idle:
            self._evict(next(iter(self._idle)))
            self._idle[connection] = None
        else:
            connection.is_probe = True
            if len(self._probes) >= SPARE:
                self._evict(next(iter(self._probes)))
            self._probes[connection] = None

    def closed(self, connection: Supervised) -> None:
        """Unregister a connection that has ended."""
        self._open.discard(connection)
        self._idle.pop(connection, None)
        self._probes.pop(connection, None)

    def moved(self, connection: Supervised) -> None:
        """Note that a connection has entered another stage."""
        self._idle.pop(connection, None)
        if connection.stage in _IDLE and connection in self._open and not connection.is_probe:
            self._idle[connection] = None

    def count(self, refusal: Refusal) -> None:
        """Count a refusal; log it if it is the first of its reason, or the first after a minute without one."""
        self._on_refusal(refusal.reason)
        now = asyncio.get_running_loop().time()
        if now - self._seen.get(refusal.reason, -_QUIET_SECONDS) >= _QUIET_SECONDS:
            structlog.get_logger("voa").warning(
                "connections are refused or ended", reason=refusal.reason, detail=refusal.detail, open=len(self._open)
            )
        self._seen[refusal.reason] = now

    def end(self) -> None:
        """End every connection, as the service stops; requests that wait for a response are answered 503."""
        for connection in list(self._open):
            connection.refuse(refusals.STOPPING)

    def _evict(self, connection: Supervised) -> None:
        self.count(refusals.EVICTED)
        self.closed(connection)
        connection.close()

    def check(self, loop: asyncio.AbstractEventLoop) -> None:
        """Refuse or end connections that make no progress; called every second while connections are open."""
        now = loop.time()
        for connection in list(self._open):
            refusal = connection.overdue(now)
            if refusal is not None:
                connection.refuse(refusal)
        self._end_the_unread()
        self._next_check = loop.call_later(_CHECK_SECONDS, self.check, loop) if self._open else None

    def _end_the_unread(self) -> None:
        """End the slowest readers while responses that wait to be read take too much memory."""
        waiting = sorted((each for each in self._open if each.unsent), key=lambda each: each.sent_at)
        held = sum(each.unsent for each in waiting)
        for connection in waiting:
            if held <= self._unsent:
                return
            held -= connection.unsent
            connection.refuse(refusals.UNREAD)
