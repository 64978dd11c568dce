"""Choice of the transport by the address of a service.

http://127.0.0.1:8000                          HTTP; https:// too
zenoh://127.0.0.1:7447                         Zenoh by TCP, root voa/v1/default
zenoh://user:password@lab:7447/voa/v1/lab7     Zenoh by TCP as a user, with another root of the keys
zenoh+tls://lab:7447?ca=ca.pem                 Zenoh by TLS
tcp/127.0.0.1:7447                             an endpoint as Zenoh writes it
"""

import re
from pathlib import Path

from voa_client._api_key import ApiKey
from voa_client._errors import UsageError
from voa_client._http import AsyncHttpTransport, HttpTransport
from voa_client._transport import AsyncTransport, Transport
from voa_client._zenoh import AsyncZenohTransport, ZenohTransport
from voa_client._zenoh_address import ENDPOINTS, SCHEMES, ZenohAddress

_HTTP = ("http", "https")


def transport_to(to: str | Transport, key: str | None, key_file: Path | str | None) -> Transport:
    """Make the transport for an address, or return the given one; raises UsageError for an invalid address or key."""
    if not isinstance(to, str):
        _check_no_key(key, key_file)
        return to
    own = ApiKey.given(key, key_file)
    return HttpTransport(to, key=own) if _is_http(to) else ZenohTransport(ZenohAddress.parse(to), own)


def async_transport_to(to: str | AsyncTransport, key: str | None, key_file: Path | str | None) -> AsyncTransport:
    """Make the transport for an address, or return the given one; raises UsageError for an invalid address or key."""
    if not isinstance(to, str):
        _check_no_key(key, key_file)
        return to
    own = ApiKey.given(key, key_file)
    return AsyncHttpTransport(to, key=own) if _is_http(to) else AsyncZenohTransport(ZenohAddress.parse(to), own)


def _check_no_key(key: str | None, key_file: Path | str | None) -> None:
    """Return if there is neither a key nor a file with one: a transport has its own; raises UsageError otherwise."""
    if key is not None or key_file is not None:
        raise UsageError("expected a key or a key file with an address only: give it to the transport instead")


def _is_http(address: str) -> bool:
    scheme, url, _ = address.partition("://")
    if url and scheme in _HTTP:
        return True
    if (url and scheme in SCHEMES) or re.match(rf"({'|'.join(ENDPOINTS)})/", address):
        return False
    known = ", ".join(f"{scheme}://" for scheme in (*_HTTP, *SCHEMES))
    raise UsageError(f"expected a URL with {known} or a Zenoh endpoint like tcp/127.0.0.1:7447, got {address!r}")
