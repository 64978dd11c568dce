"""Choice of the transport by the address of a service.

http://127.0.0.1:8000                          HTTP; https:// too
zenoh://127.0.0.1:7447                         Zenoh by TCP, root voa/v1/default
zenoh://user:password@lab:7447/voa/v1/lab7     Zenoh by TCP as a user, with another root of the keys
zenoh+tls://lab:7447?ca=ca.pem                 Zenoh by TLS
tcp/127.0.0.1:7447                             an endpoint as Zenoh writes it
"""

import re

from voa_client._errors import UsageError
from voa_client._http import AsyncHttpTransport, HttpTransport
from voa_client._transport import AsyncTransport, Transport
from voa_client._zenoh import AsyncZenohTransport, ZenohTransport
from voa_client._zenoh_address import ENDPOINTS, SCHEMES, ZenohAddress

_HTTP = ("http", "https")


def transport_to(address: str) -> Transport:
    """Make the transport for an address; raises UsageError if the address is not valid."""
    if _is_http(address):
        return HttpTransport(address)
    return ZenohTransport(ZenohAddress.parse(address))


def async_transport_to(address: str) -> AsyncTransport:
    """Make the transport for an address, for asyncio; raises UsageError if the address is not valid."""
    if _is_http(address):
        return AsyncHttpTransport(address)
    return AsyncZenohTransport(ZenohAddress.parse(address))


def _is_http(address: str) -> bool:
    scheme, url, _ = address.partition("://")
    if url and scheme in _HTTP:
        return True
    if (url and scheme in SCHEMES) or re.match(rf"({'|'.join(ENDPOINTS)})/", address):
        return False
    known = ", ".join(f"{scheme}://" for scheme in (*_HTTP, *SCHEMES))
    raise UsageError(f"expected a URL with {known} or a Zenoh endpoint like tcp/127.0.0.1:7447, got {address!r}")
