"""All connections of the HTTP server: how many there may be, which is closed for another, and which has hung."""

import asyncio
from collections.abc import Callable
from functools import partial

import structlog

from voa_service.http.connections import refusals
from voa_service.http.connections.connection import Connection, Stage
from voa_service.http.connections.in_flight import ByteBudget
from voa_service.http.connections.refusals import Refusal
from voa_service.runtime.metrics import Metrics
from voa_service.settings import MEBIBYTE, ConnectionSettings

RESERVED_FILES = 256
"""Of the files that the process may open: for the database, Zenoh, meshes, and what follows."""
SPARE = 64
"""Connections above the most, on which health probes are answered and everything else refused."""
_IDLE = frozenset({Stage.SILENT, Stage.HEADERS, Stage.CLOSING})
_LOOK_SECONDS = 1.0
_QUIET_SECONDS = 60.0


def most_connections(settings: ConnectionSettings, files: int) -> int:
    """Give how many connections there may be where the process may open so many files."""
    return min(settings.most, max(files - RESERVED_FILES, files // 2))


class Guard:
    """Looks after connections: call `protocol` for each new one.

    Args:
        settings: bounds.
        metrics: counts refusals by reason.
        files: how many the process may open (RLIMIT_NOFILE).
    """

    def __init__(self, settings: ConnectionSettings, metrics: Metrics, files: int) -> None:
        self._settings = settings
        self._metrics = metrics
        self._most = most_connections(settings, files)
        self._unsent = settings.in_flight_mebibytes * MEBIBYTE
        self.budget = ByteBudget(self._unsent, self.count)
        self._open: set[Connection] = set()
        self._idle: dict[Connection, None] = {}  # those without a request under way, the longest first
        self._probes: dict[Connection, None] = {}  # those above the most, the oldest first
        self._seen: dict[str, float] = {}
        self._look: asyncio.TimerHandle | None = None
        self.too_many = refusals.too_many_connections(self._most)
        metrics.gauge("voa_http_connections", "Connections that are open.", lambda: len(self._open))
        metrics.gauge("voa_http_bytes_in_flight", "Bytes of large bodies that are held.", lambda: self.budget.held)

    @property
    def protocol(self) -> Callable[..., Connection]:
        """Give what uvicorn makes a protocol with."""
        return partial(Connection, self, self._settings)

    def opened(self, connection: Connection) -> None:
        """Count a new connection; where there are too many, close the one that is idle the longest."""
        self._open.add(connection)
        if self._look is None:
            self._look = connection.loop.call_later(_LOOK_SECONDS, self.look, connection.loop)
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

    def closed(self, connection: Connection) -> None:
        """Forget a connection."""
        self._open.discard(connection)
        self._idle.pop(connection, None)
        self._probes.pop(connection, None)

    def moved(self, connection: Connection) -> None:
        """Note that a connection entered another stage."""
        self._idle.pop(connection, None)
        if connection.stage in _IDLE and connection in self._open and not connection.is_probe:
            self._idle[connection] = None

    def count(self, refusal: Refusal) -> None:
        """Count a refusal, and log one line when its kind begins, or begins again after a minute without."""
        self._metrics.connection(refusal.reason)
        now = asyncio.get_running_loop().time()
        if now - self._seen.get(refusal.reason, -_QUIET_SECONDS) >= _QUIET_SECONDS:
            structlog.get_logger("voa").warning(
                "connections are refused or ended", reason=refusal.reason, detail=refusal.detail, open=len(self._open)
            )
        self._seen[refusal.reason] = now

    def end(self) -> None:
        """End every connection, as the service stops: those that wait for an answer are told."""
        for connection in list(self._open):
            connection.refuse(refusals.STOPPING)

    def _evict(self, connection: Connection) -> None:
        self.count(refusals.EVICTED)
        self.closed(connection)
        connection.close()

    def look(self, loop: asyncio.AbstractEventLoop) -> None:
        """Refuse or end what has hung; called every second while there are connections."""
        now = loop.time()
        for connection in list(self._open):
            refusal = connection.overdue(now)
            if refusal is not None:
                connection.refuse(refusal)
        self._end_the_unread()
        self._look = loop.call_later(_LOOK_SECONDS, self.look, loop) if self._open else None

    def _end_the_unread(self) -> None:
        """Keep the answers that wait for slow readers within bounds."""
        waiting = sorted((each for each in self._open if each.unsent), key=lambda each: each.sent_at)
        held = sum(each.unsent for each in waiting)
        for connection in waiting:
            if held <= self._unsent:
                return
            held -= connection.unsent
            connection.refuse(refusals.UNREAD)
