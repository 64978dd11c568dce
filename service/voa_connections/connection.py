"""The protocol of an HTTP connection: uvicorn's, with its bytes counted and its stages timed."""

import asyncio
import socket
import struct
from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from typing import TYPE_CHECKING, Any

import httptools
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from voa_connections import refusals
from voa_connections.refusals import Refusal
from voa_connections.responses import http_bytes
from voa_connections.settings import ConnectionSettings

if TYPE_CHECKING:
    from voa_connections.supervisor import ConnectionSupervisor

_MOST_PIPELINED = 16
_RESET = struct.pack("ii", 1, 0)  # SO_LINGER: on, for no time
_LINGER_SECONDS = 2.0
_PROBES = (b"/livez", b"/readyz", b"/metrics")


class Stage(Enum):
    """Stages of a request on a connection."""

    SILENT = "no byte of a request has arrived"
    HEADERS = "some of its headers have arrived"
    BODY = "its headers have arrived, its body has not ended"
    WORKING = "all of it has arrived"
    CLOSING = "it was refused: further bytes are dropped"


class Connection(HttpToolsProtocol):
    """A connection of the HTTP server.

    Args:
        supervisor: of all connections of the server.
        settings: bounds on headers, bodies and times.
        uvicorns: arguments that uvicorn passes to its protocols.
    """

    def __init__(self, supervisor: "ConnectionSupervisor", settings: ConnectionSettings, **uvicorns: Any) -> None:
        super().__init__(**uvicorns)
        self._supervisor = supervisor
        self._settings = settings
        self._too_large = refusals.headers_too_large(settings.header_bytes, settings.headers)
        self.stage = Stage.SILENT
        self.since = self.loop.time()
        self.is_probe = False
        """True where only health probes are answered, because there are too many connections."""
        self._refusal: Refusal | None = None
        self._chunk = 0  # bytes of the piece that is being parsed
        self._parsing = 0  # bytes of whole pieces since the last part of a request; the parser may hold them
        self._body_bytes = 0  # bytes of the body that arrived since `since`
        self._was_paused = False
        self._is_upgraded = False
        self._has_requested = False
        self._unanswered = 0
        self._most_unsent = 0
        self.sent_at = self.since
        """Time of the event loop at which the peer last read bytes, or had none to read."""
        self.on_made: Callable[[], None] | None = None
        """Called when the connection is open, before it is registered."""

    @property
    def unsent(self) -> int:
        """Bytes of responses that the peer has not read yet."""
        return self.transport.get_write_buffer_size()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's
        """Register a new connection."""
        super().connection_made(transport)
        if self.on_made is not None:
            self.on_made()
        self._supervisor.opened(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Unregister a connection that has ended."""
        self._supervisor.closed(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse bytes from the peer; refuses them where they are too many, or not HTTP."""
        if self.stage is Stage.CLOSING or self._is_upgraded:
            return
        self._unset_keepalive_if_required()
        if self.stage is Stage.SILENT:
            self._enter(Stage.HEADERS)
            self._parsing = 0
        self._chunk = len(data)
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade:
            # No other protocol is supported: the request is answered, and the bytes after it are not read.
            self._is_upgraded = True
            if self._refusal is None:
                self.cycle.keep_alive = False
        except httptools.HttpParserError:
            self.refuse(self._refusal or refusals.MALFORMED)
            return
        self._parsing += self._chunk
        if self._refusal is None and self._holds_too_much():
            self._refusal = self._too_large
        if self._refusal is not None:
            self.refuse(self._refusal)

    def on_message_begin(self) -> None:
        """Note the start of a request."""
        self._parsing = -self._chunk
        if self.stage is not Stage.HEADERS:
            self._enter(Stage.HEADERS)
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        """Start serving a request, unless its headers are refused."""
        self._refusal = self._refusal or self._refusal_of_headers()
        if self._refusal is not None:
            return
        self._parsing = -self._chunk
        self._body_bytes = 0
        self._was_paused = False
        self._enter(Stage.BODY)
        self._has_requested = True
        self._unanswered += 1
        super().on_headers_complete()
        if self.is_probe or self._supervisor.is_draining:
            self.cycle.keep_alive = False

    def on_body(self, body: bytes) -> None:
        """Pass on a part of a request's body."""
        if self._refusal is None:
            self._parsing = -self._chunk
            self._body_bytes += len(body)
            super().on_body(body)

    def on_message_complete(self) -> None:
        """Note the end of a request, whose response may still be under way."""
        if self._refusal is None:
            super().on_message_complete()
            self._enter(Stage.SILENT if self.cycle.response_complete else Stage.WORKING)

    def on_response_complete(self) -> None:
        """Note the end of a response."""
        self._unanswered -= 1
        super().on_response_complete()
        if self._unanswered == 0 and self.stage is Stage.WORKING:
            self._enter(Stage.SILENT)

    def overdue(self, now: float) -> Refusal | None:
        """Return the reason to end the connection, or None; called every second with the event loop's time."""
        settings, seconds = self._settings, now - self.since
        stalled = self._is_stalled(now)
        if self.stage is Stage.CLOSING or stalled:
            return refusals.STALLED if stalled or seconds > _LINGER_SECONDS else None
        if self.stage is Stage.HEADERS and seconds > settings.header_seconds:
            return refusals.header_timeout(settings.header_seconds)
        if self.stage is Stage.SILENT and not self._has_requested and seconds > settings.header_seconds:
            return refusals.SILENT
        if self.stage is Stage.BODY and seconds > settings.progress_seconds:
            # Where the application does not read, no bytes arrive, and the peer is not to blame.
            paused = self.flow.read_paused
            if not (paused or self._was_paused or self._body_bytes >= settings.progress_bytes):
                return refusals.body_timeout(settings.progress_bytes, settings.progress_seconds)
            self.since, self._body_bytes, self._was_paused = now, 0, paused
        return None

    def refuse(self, refusal: Refusal) -> None:
        """Send the response of a refusal where a response is still possible, and end the connection."""
        self._supervisor.count(refusal)
        if self.stage is Stage.CLOSING or self.transport.is_closing():
            self._abort()
            return
        answerable = refusal.answer is not None and self._can_answer()
        if self._unanswered and not self.cycle.response_complete:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if not answerable:
            self._abort()
            return
        self.transport.write(http_bytes(self._supervisor.respond(refusal)))
        self._enter(Stage.CLOSING)
        # The peer may still be sending: if its bytes were not read, the response could be lost with the connection.
        self.flow.resume_reading()
        if self.transport.can_write_eof():
            self.transport.write_eof()
        else:  # TLS has no half-closed connections
            self.loop.call_later(_LINGER_SECONDS / 2, self.transport.close)

    def close(self) -> None:
        """End a connection that has no request under way."""
        if self.stage is Stage.SILENT and self.unsent == 0:
            self.transport.close()
        else:
            self._abort()

    def _enter(self, stage: Stage) -> None:
        self.stage = stage
        self.since = self.loop.time()
        self._supervisor.moved(self)

    def _abort(self) -> None:
        """End the connection with a reset, so that the kernel drops the bytes that the peer does not read."""
        opened = self.transport.get_extra_info("socket")
        if opened is not None:
            with suppress(OSError):
                opened.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
        self.transport.abort()

    def _can_answer(self) -> bool:
        """Return True if the next bytes sent would be the response to the request that is being received."""
        if self.stage in (Stage.SILENT, Stage.HEADERS):
            return self.stage is Stage.HEADERS and self._unanswered == 0
        return self._unanswered == 1 and not self.cycle.response_started

    def _holds_too_much(self) -> bool:
        """Return True if the headers of a request, or the bytes that the parser keeps, exceed their bounds."""
        if self.stage is Stage.HEADERS and len(self.headers or ()) > self._settings.headers:
            return True
        return self.stage in (Stage.HEADERS, Stage.BODY) and self._parsing > self._settings.header_bytes

    def _refusal_of_headers(self) -> Refusal | None:
        most = self._settings.header_bytes
        if len(self.headers) > self._settings.headers:
            return self._too_large
        if self._parsing + 2 * self._chunk > most:  # a smaller request cannot have too large headers
            size = len(self.url) + sum(len(name) + len(value) for name, value in self.headers)
            if size > most:
                return self._too_large
        if len(self.pipeline) >= _MOST_PIPELINED:
            return refusals.PIPELINED
        if self.is_probe and self.url.partition(b"?")[0] not in _PROBES:
            return self._supervisor.too_many
        return None

    def _is_stalled(self, now: float) -> bool:
        """Return True if the peer has hardly read from its responses for `progress_seconds`."""
        unsent = self.unsent
        if unsent == 0 or unsent <= self._most_unsent - self._settings.progress_bytes:
            self._most_unsent, self.sent_at = unsent, now
            return False
        self._most_unsent = max(self._most_unsent, unsent)
        return now - self.sent_at > self._settings.progress_seconds
