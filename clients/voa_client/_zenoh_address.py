"""Addresses of Zenoh routers, with credentials."""

from dataclasses import dataclass
from typing import Self
from urllib.parse import parse_qsl, unquote, urlsplit

from voa_client._errors import UsageError
from voa_msgs.keys import ROOT, check_root

SCHEMES = {"zenoh": "tcp", "zenoh+tls": "tls"}
"""URL schemes, and the protocol of the link that each stands for."""
ENDPOINTS = ("tcp", "tls", "quic", "ws", "udp", "unixsock-stream")
"""Protocols of endpoints as Zenoh writes them."""
PORT = 7447


@dataclass(frozen=True)
class ZenohAddress:
    """Address of a Zenoh router, and the root of the service's keys on it.

    Attributes:
        endpoint: as Zenoh writes it, `tcp/host:port`.
        root: of the keys.
        user: to connect as; None: without a user.
        password: of the user.
        ca: file with the certificate of the authority that signed the router's; None: the system's authorities.
        cert: file with the client's certificate; None: none.
        key: file with the private key of that certificate.
    """

    endpoint: str
    root: str = ROOT
    user: str | None = None
    password: str | None = None
    ca: str | None = None
    cert: str | None = None
    key: str | None = None

    @classmethod
    def parse(cls, address: str) -> Self:
        """Parse a `zenoh://` or `zenoh+tls://` URL, or an endpoint; raises UsageError if it is not valid."""
        if "://" not in address:
            return cls(address)
        scheme = address.partition("://")[0]
        if scheme not in SCHEMES:
            raise UsageError(f"{_safe(address)}: expected {' or '.join(f'{known}://' for known in SCHEMES)}")
        try:
            url = urlsplit(address)
            host, port = url.hostname, url.port or PORT
            more = dict(parse_qsl(url.query, keep_blank_values=True, strict_parsing=bool(url.query)))
            root = check_root(url.path.strip("/") or ROOT)
        except ValueError as error:
            raise UsageError(f"{_safe(address)}: {error}") from error
        unknown = sorted(set(more) - {"ca", "cert", "key"})
        if not host or unknown:
            wrong = f"unknown {unknown[0]!r}" if unknown else "no host"
            raise UsageError(f"{_safe(address)}: {wrong}; expected zenoh://[user:password@]host[:port][/root]")
        return cls(
            endpoint=f"{SCHEMES[url.scheme]}/{f'[{host}]' if ':' in host else host}:{port}",
            root=root,
            user=None if url.username is None else unquote(url.username),
            password=None if url.password is None else unquote(url.password),
            **more,
        )


def _safe(address: str) -> str:
    """Remove user and password from a URL."""
    scheme, _, rest = address.partition("://")
    return f"{scheme}://{rest.rpartition('@')[2]}"
