"""The HTTP server process: uvicorn's, with a stop in bounded time."""

import asyncio
import resource
import socket
from functools import partial
from types import FrameType

import uvicorn

from voa_connections.handshake import ServerCertificate, accept
from voa_connections.settings import ConnectionSettings
from voa_connections.supervisor import ConnectionSupervisor
from voa_service.http.refusals import refusal_response
from voa_service.runtime.changes import Changes
from voa_service.runtime.metrics import Metrics
from voa_service.runtime.stopping import Deadline

_ANSWERED_BY = 0.4
"""Share of the time to stop after which requests that are still under way are answered 503."""
_DRAINED_BY = 0.5
"""Share of the time to stop after which the HTTP server waits for no request any more."""


def supervised(settings: ConnectionSettings, metrics: Metrics) -> ConnectionSupervisor:
    """Make the supervisor of the server's connections, with its metrics."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    connections = ConnectionSupervisor(settings, files, refusal_response, metrics.connection)
    held = "Bytes of large request bodies in memory."
    metrics.gauge("voa_http_connections", "HTTP connections that are open.", lambda: connections.connections)
    metrics.gauge("voa_http_bytes_in_flight", held, lambda: connections.budget.held)
    return connections


class Server(uvicorn.Server):
    """An HTTP server that stops in bounded time.

    Args:
        config: of the server, as uvicorn expects it.
        changes: ends the event streams, which would go on for ever.
        connections: of the server.
        deadline: starts when the process receives a signal to stop.
        stop_seconds: from that signal to the end of the process.
        certificate: for HTTPS; None: HTTP.
    """

    def __init__(
        self,
        config: uvicorn.Config,
        changes: Changes,
        connections: ConnectionSupervisor,
        deadline: Deadline,
        stop_seconds: float,
        certificate: ServerCertificate | None = None,
    ) -> None:
        config.timeout_graceful_shutdown = max(1, round(stop_seconds * _DRAINED_BY))
        super().__init__(config)
        self._changes = changes
        self._connections = connections
        self._deadline = deadline
        self._answered_by = stop_seconds * _ANSWERED_BY
        self._certificate = certificate
        self._accepting: list[asyncio.Task[None]] = []

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop, in the handler of a signal."""
        self._deadline.begin()
        self._changes.close()
        super().handle_exit(sig, frame)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to accept connections; those with TLS are supervised from their first byte, unlike uvicorn's."""
        if self._certificate is None:
            await super().startup(sockets)
            return
        await super().startup([])
        for listening in sockets or []:
            listening.listen(self.config.backlog)
            listening.setblocking(False)
            self._accepting.append(asyncio.create_task(accept(listening, partial(self._shake, self._certificate))))

    def _shake(self, certificate: ServerCertificate, accepted: socket.socket) -> None:
        uvicorns = {"config": self.config, "server_state": self.server_state, "app_state": self.lifespan.state}
        self._connections.shake(accepted, certificate.context, partial(self._connections.protocol, **uvicorns))

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Wait for requests to end, then answer those still under way that the service is stopping."""
        for task in self._accepting:
            task.cancel()
        late = asyncio.get_running_loop().call_later(self._answered_by, self._connections.end)
        try:
            await super().shutdown(sockets)
        finally:
            late.cancel()
