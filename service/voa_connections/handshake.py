"""TLS: the handshake of a connection, before which there is no request, and the certificate, which may be renewed."""

import asyncio
import socket
import ssl
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from voa_connections import refusals
from voa_connections.connection import Connection, Stage
from voa_connections.refusals import Refusal

if TYPE_CHECKING:
    from voa_connections.supervisor import ConnectionSupervisor

_SHUTDOWN_SECONDS = 2.0
_AGAIN_SECONDS = 0.1


class UnusableCertificate(Exception):
    """Error for a certificate or private key that cannot be used; its text says which file, and what was expected."""


class ServerCertificate:
    """Certificate of the server, with its private key, as read from their files.

    Args:
        certificate: PEM file with the certificate, followed by those of intermediate authorities.
        key: PEM file with the private key, not encrypted.

    Raises:
        UnusableCertificate: a file cannot be read, or the key is not that of the certificate.
    """

    def __init__(self, certificate: Path, key: Path) -> None:
        self._certificate, self._key = certificate, key
        self.context = self._read()

    def reload(self) -> None:
        """Read both files again; new connections use them. Raises UnusableCertificate, and keeps the old ones then."""
        self.context = self._read()

    def _read(self) -> ssl.SSLContext:
        for file in (self._certificate, self._key):
            try:
                file.read_bytes()
            except OSError as error:
                raise UnusableCertificate(f"cannot read {file}: {error.strerror}") from error
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.set_alpn_protocols(["http/1.1"])
        try:
            context.load_cert_chain(self._certificate, self._key, password=_refuse_encrypted)
        except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
            raise UnusableCertificate(
                f"{self._certificate} and {self._key}: expected a certificate and its private key, not encrypted, as "
                f"PEM ({getattr(error, 'reason', None) or error})"
            ) from error
        return context


def _refuse_encrypted() -> str:
    """Refuse to decrypt a key; without this function OpenSSL would read a password from the terminal."""
    raise ValueError("the key is encrypted")


class Handshake:
    """A connection until its TLS handshake ends: supervised like any other that has not sent a request.

    Args:
        supervisor: of all connections of the server.
        seconds: time for the handshake.
        accepted: socket of the connection.
        context: of the server's certificate.
        connect: makes the protocol of the connection, which takes over after the handshake.
    """

    is_probe = False
    stage = Stage.SILENT
    unsent = 0

    def __init__(
        self,
        supervisor: "ConnectionSupervisor",
        seconds: float,
        accepted: socket.socket,
        context: ssl.SSLContext,
        connect: Callable[[], Connection],
    ) -> None:
        self._supervisor = supervisor
        self._seconds = seconds
        self.loop = asyncio.get_running_loop()
        self.sent_at = self._since = self.loop.time()
        supervisor.opened(self)
        self._task = self.loop.create_task(self._shake(accepted, context, connect))

    def overdue(self, now: float) -> Refusal | None:
        """Return the reason to end the connection, or None; called every second with the event loop's time."""
        return refusals.HANDSHAKE if now - self._since > self._seconds else None

    def refuse(self, refusal: Refusal) -> None:
        """End the connection: nothing can be answered before TLS."""
        self._supervisor.count(refusal)
        self.close()

    def close(self) -> None:
        """End the connection."""
        self._task.cancel()

    async def _shake(self, accepted: socket.socket, context: ssl.SSLContext, connect: Callable[[], Connection]) -> None:
        connection = connect()
        connection.on_made = lambda: self._supervisor.closed(self)
        try:
            await self.loop.connect_accepted_socket(
                lambda: connection,
                accepted,
                ssl=context,
                ssl_handshake_timeout=2 * self._seconds,  # the supervisor ends it before
                ssl_shutdown_timeout=_SHUTDOWN_SECONDS,
            )
        except OSError:
            pass  # the peer does not speak TLS, or not of a version in use, or is gone
        finally:
            self._supervisor.closed(self)


async def accept(listening: socket.socket, begin: Callable[[socket.socket], object]) -> None:
    """Accept connections until cancelled, each of which is passed to `begin`."""
    loop = asyncio.get_running_loop()
    while True:
        try:
            accepted, _ = await loop.sock_accept(listening)
        except OSError:  # no file is left for it, or the peer is gone
            await asyncio.sleep(_AGAIN_SECONDS)
            continue
        accepted.setblocking(False)
        begin(accepted)
