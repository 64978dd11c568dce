"""The HTTP server process: uvicorn's, with a stop in order and in bounded time."""

import asyncio
import resource
import signal
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
from voa_service.runtime.stopping import Deadline, Drain

_ANSWERED_BY = 0.4
"""Share of the time after the drain from which on requests that are still under way are answered 503."""
_FINISHED_BY = 0.5
"""Share of the time after the drain from which on the HTTP server waits for no request any more."""


def supervised(settings: ConnectionSettings, metrics: Metrics) -> ConnectionSupervisor:
    """Make the supervisor of the server's connections, with its metrics."""
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    connections = ConnectionSupervisor(settings, files, refusal_response, metrics.connection)
    held = "Bytes of large request bodies in memory."
    metrics.gauge("voa_http_connections", "HTTP connections that are open.", lambda: connections.connections)
    metrics.gauge("voa_http_bytes_in_flight", held, lambda: connections.budget.held)
    return connections


class Server(uvicorn.Server):
    """An HTTP server that stops in order and in bounded time.

    At SIGTERM it drains first: `/readyz` is answered 503, every response ends its connection, and all requests are
    served. Then, or at once after another signal, it accepts no more connections and waits for requests under way.

    Args:
        config: of the server, as uvicorn expects it.
        changes: ends the event streams, which would go on for ever.
        connections: of the server.
        deadline: starts when the process receives a signal to stop.
        drain: starts at SIGTERM.
        stop_seconds: from that signal to the end of the process.
        certificate: for HTTPS; None: HTTP.
    """

    def __init__(
        self,
        config: uvicorn.Config,
        changes: Changes,
        connections: ConnectionSupervisor,
        deadline: Deadline,
        drain: Drain,
        stop_seconds: float,
        certificate: ServerCertificate | None = None,
    ) -> None:
        left = stop_seconds - drain.seconds
        config.timeout_graceful_shutdown = max(1, round(left * _FINISHED_BY))
        super().__init__(config)
        self._changes = changes
        self._connections = connections
        self._deadline = deadline
        self._drain = drain
        self._answered_by = left * _ANSWERED_BY
        self._certificate = certificate
        self._accepting: list[asyncio.Task[None]] = []

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop, in the handler of a signal."""
        self._deadline.begin()
        drains = sig == signal.SIGTERM and self._drain.seconds > 0 and not self._drain.has_begun
        self._drain.begin()
        if drains:
            self._connections.is_draining = True
        else:
            self._changes.close()
            super().handle_exit(sig, frame)

    async def on_tick(self, counter: int) -> bool:
        """Return True once the server must stop; called every 0.1 s."""
        if self._drain.is_over and not self.should_exit:
            self._changes.close()
            self.should_exit = True
        return await super().on_tick(counter)

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
