"""A protocol of the HTTP server without a network: bytes in, bytes out, and a clock that is set by hand."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import uvicorn
from uvicorn.server import ServerState

from voa_connections.asgi import Receive, Scope, Send
from voa_connections.connection import Connection
from voa_connections.in_flight import BytesInFlight
from voa_connections.settings import ConnectionSettings
from voa_connections.supervisor import ConnectionSupervisor
from voa_service.http.refusals import refusal_response
from voa_service.runtime.metrics import Metrics


class Wire(asyncio.Transport):
    """Transport that a protocol writes to, and how much of it the peer has not read."""

    def __init__(self) -> None:
        super().__init__()
        self.written = b""
        self.unsent = 0
        self.ended = False
        self.aborted = False
        self.paused = False
        self.half_closed = False

    def write(self, data: Any) -> None:
        self.written += bytes(data)

    def can_write_eof(self) -> bool:
        return True

    def write_eof(self) -> None:
        self.half_closed = True

    def get_write_buffer_size(self) -> int:
        return self.unsent

    def pause_reading(self) -> None:
        self.paused = True

    def resume_reading(self) -> None:
        self.paused = False

    def is_closing(self) -> bool:
        return self.ended

    def close(self) -> None:
        self.ended = True

    def abort(self) -> None:
        self.ended = self.aborted = True

    def is_read(self) -> bool:
        """True if bytes from the peer are read."""
        return not self.paused

    @property
    def statuses(self) -> list[int]:
        """Status codes of all responses."""
        return [int(each.split(b" ", 1)[0]) for each in self.written.split(b"HTTP/1.1 ")[1:]]

    @property
    def problem(self) -> dict[str, Any]:
        """The document of the last answer, which must be a problem."""
        headers, _, body = self.written.rpartition(b"HTTP/1.1 ")[2].partition(b"\r\n\r\n")
        assert b"application/problem+json" in headers.lower()
        document: dict[str, Any] = json.loads(body)
        return document


class Application:
    """Answers with the length of the body; holds requests to /held until it is let go."""

    def __init__(self) -> None:
        self.go = asyncio.Event()
        self.paths: list[str] = []
        self.ended: list[str] = []

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self.paths.append(scope["path"])
        length, more = 0, True
        while more:
            message = await receive()
            if message["type"] == "http.disconnect":
                self.ended.append(scope["path"])
                return
            length += len(message["body"])
            more = message["more_body"]
            if scope["path"] == "/held":
                await self.go.wait()
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"0")]})
        await send({"type": "http.response.body", "body": b""})


class Host:
    """A supervisor, an application, and connections to it."""

    def __init__(self, files: int = 10_000, **settings: Any) -> None:
        self.settings = ConnectionSettings(**settings)
        self.metrics = Metrics()
        self.supervisor = ConnectionSupervisor(self.settings, files, refusal_response, self.metrics.connection)
        self.application = Application()
        self._state = ServerState()
        self._config = uvicorn.Config(
            BytesInFlight(self.application, self.supervisor.budget, refusal_response),
            http=Connection,
            ws="none",
            log_config=None,
        )

    @property
    def uvicorns(self) -> dict[str, Any]:
        """Arguments that uvicorn passes to its protocols."""
        return {"config": self._config, "server_state": self._state, "app_state": {}}

    def connect(self) -> tuple[Connection, Wire]:
        """Open a connection."""
        connection = self.supervisor.protocol(**self.uvicorns)
        wire = Wire()
        connection.connection_made(wire)
        return connection, wire

    def refused(self, reason: str) -> float:
        """Read the metric of a reason."""
        name = f'voa_http_connections_refused_total{{reason="{reason}"}}'
        lines = self.metrics.text().decode().splitlines()
        return next((float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith(name)), 0.0)


async def settled() -> None:
    """Let every task run until it waits for something."""
    for _ in range(20):
        await asyncio.sleep(0)


def run(scenario: Callable[[], Awaitable[None]]) -> None:
    """Run a test that needs an event loop."""

    async def run() -> None:
        await scenario()

    asyncio.run(run())
