"""One connection: uvicorn's protocol, with its bytes counted and its stages timed."""

import asyncio
import socket
import struct
from contextlib import suppress
from enum import Enum
from typing import TYPE_CHECKING, Any

import httptools
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from voa_service.http.connections import refusals
from voa_service.http.connections.refusals import Refusal
from voa_service.settings import ConnectionSettings

if TYPE_CHECKING:
    from voa_service.http.connections.guard import Guard

_MOST_PIPELINED = 16
_RESET = struct.pack("ii", 1, 0)  # SO_LINGER: on, for no time
_LINGER_SECONDS = 2.0
_PROBES = (b"/livez", b"/readyz", b"/metrics")


class Stage(Enum):
    """How far a connection is with the request that it sends."""

    SILENT = "no byte of a request has come"
    HEADERS = "some of its headers have come"
    BODY = "its headers have come, its body has not ended"
    WORKING = "all of it has come"
    CLOSING = "it was refused: whatever else comes is thrown away"


class Connection(HttpToolsProtocol):
    """A connection of the HTTP server.

    Args:
        guard: looks after all connections.
        settings: bounds.
        uvicorns: what uvicorn gives to its protocols.
    """

    def __init__(self, guard: "Guard", settings: ConnectionSettings, **uvicorns: Any) -> None:
        super().__init__(**uvicorns)
        self._guard = guard
        self._settings = settings
        self._too_large = refusals.headers_too_large(settings.header_bytes, settings.headers)
        self.stage = Stage.SILENT
        self.since = self.loop.time()
        self.is_probe = False
        """Whether only health probes are answered, as there are too many connections."""
        self._refusal: Refusal | None = None
        self._chunk = 0  # bytes of the piece that is being parsed
        self._parsing = 0  # bytes of whole pieces since the last part of a request; the parser may hold them
        self._came = 0  # bytes of the body since `since`
        self._was_paused = False
        self._is_upgraded = False
        self._has_asked = False
        self._unanswered = 0
        self._most_unsent = 0
        self.sent_at = self.since
        """When the peer was last seen to read, or there was nothing to read."""

    @property
    def unsent(self) -> int:
        """Bytes of answers that wait for the peer to read."""
        return self.transport.get_write_buffer_size()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's
        """Begin."""
        super().connection_made(transport)
        self._guard.opened(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._guard.closed(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse a piece of what the peer sends, unless it is too much."""
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
            # Not spoken here: the request is answered, and what follows, in another protocol, is not read.
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
        """Begin a request."""
        self._parsing = -self._chunk
        if self.stage is not Stage.HEADERS:
            self._enter(Stage.HEADERS)
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        """Begin to serve a request, unless it is refused for its headers."""
        self._refusal = self._refusal or self._refusal_of_headers()
        if self._refusal is not None:
            return
        self._parsing = -self._chunk
        self._came = 0
        self._was_paused = False
        self._enter(Stage.BODY)
        self._has_asked = True
        self._unanswered += 1
        super().on_headers_complete()
        if self.is_probe:
            self.cycle.keep_alive = False

    def on_body(self, body: bytes) -> None:
        """Take a piece of a body."""
        if self._refusal is None:
            self._parsing = -self._chunk
            self._came += len(body)
            super().on_body(body)

    def on_message_complete(self) -> None:
        """End a request."""
        if self._refusal is None:
            super().on_message_complete()
            self._enter(Stage.SILENT if self.cycle.response_complete else Stage.WORKING)

    def on_response_complete(self) -> None:
        """End an answer."""
        self._unanswered -= 1
        super().on_response_complete()
        if self._unanswered == 0 and self.stage is Stage.WORKING:
            self._enter(Stage.SILENT)

    def overdue(self, now: float) -> Refusal | None:
        """Say why the connection should end, if it should; for a call every second or so, at the loop's time `now`."""
        settings, seconds = self._settings, now - self.since
        stalled = self._is_stalled(now)
        if self.stage is Stage.CLOSING or stalled:
            return refusals.STALLED if stalled or seconds > _LINGER_SECONDS else None
        if self.stage is Stage.HEADERS and seconds > settings.header_seconds:
            return refusals.header_timeout(settings.header_seconds)
        if self.stage is Stage.SILENT and not self._has_asked and seconds > settings.header_seconds:
            return refusals.SILENT
        if self.stage is Stage.BODY and seconds > settings.progress_seconds:
            # What is not read by the application does not come, and that is not the peer's fault.
            paused = self.flow.read_paused
            if not (paused or self._was_paused or self._came >= settings.progress_bytes):
                return refusals.body_timeout(settings.progress_bytes, settings.progress_seconds)
            self.since, self._came, self._was_paused = now, 0, paused
        return None

    def refuse(self, refusal: Refusal) -> None:
        """Answer a refusal where that is still possible, and end the connection."""
        self._guard.count(refusal)
        if self.stage is Stage.CLOSING or self.transport.is_closing():
            self._abort()
            return
        answerable = refusal.kind is not None and self._can_answer()
        if self._unanswered and not self.cycle.response_complete:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if not answerable:
            self._abort()
            return
        self.transport.write(refusals.response(refusal))
        self._enter(Stage.CLOSING)
        # The peer may still be sending: were its bytes not read, the answer could be lost with the connection.
        self.flow.resume_reading()
        self.transport.write_eof()

    def close(self) -> None:
        """End a connection without a request under way."""
        if self.stage is Stage.SILENT and self.unsent == 0:
            self.transport.close()
        else:
            self._abort()

    def _enter(self, stage: Stage) -> None:
        self.stage = stage
        self.since = self.loop.time()
        self._guard.moved(self)

    def _abort(self) -> None:
        """End the connection with a reset, so that the system does not keep what the peer does not read either."""
        opened = self.transport.get_extra_info("socket")
        if opened is not None:
            with suppress(OSError):
                opened.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
        self.transport.abort()

    def _can_answer(self) -> bool:
        """Tell whether the next bytes to be sent are those of an answer to what is being received."""
        if self.stage in (Stage.SILENT, Stage.HEADERS):
            return self.stage is Stage.HEADERS and self._unanswered == 0
        return self._unanswered == 1 and not self.cycle.response_started

    def _holds_too_much(self) -> bool:
        """Tell whether the parser, or the request's headers, grow without end."""
        if self.stage is Stage.HEADERS and len(self.headers or ()) > self._settings.headers:
            return True
        return self.stage in (Stage.HEADERS, Stage.BODY) and self._parsing > self._settings.header_bytes

    def _refusal_of_headers(self) -> Refusal | None:
        most = self._settings.header_bytes
        if len(self.headers) > self._settings.headers:
            return self._too_large
        if self._parsing + 2 * self._chunk > most:  # else they cannot be too large
            size = len(self.url) + sum(len(name) + len(value) for name, value in self.headers)
            if size > most:
                return self._too_large
        if len(self.pipeline) >= _MOST_PIPELINED:
            return refusals.PIPELINED
        if self.is_probe and self.url.partition(b"?")[0] not in _PROBES:
            return self._guard.too_many
        return None

    def _is_stalled(self, now: float) -> bool:
        """Tell whether the peer has read next to nothing of what waits for it."""
        unsent = self.unsent
        if unsent == 0 or unsent <= self._most_unsent - self._settings.progress_bytes:
            self._most_unsent, self.sent_at = unsent, now
            return False
        self._most_unsent = max(self._most_unsent, unsent)
        return now - self.sent_at > self._settings.progress_seconds
