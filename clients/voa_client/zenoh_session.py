"""Zenoh sessions with a router, for programs that publish or subscribe themselves.

Zenoh's library is imported when a session is opened, not with this module.
"""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from voa_client._errors import UsageError, VoaClientError
from voa_client._zenoh_address import ENDPOINTS, SCHEMES, ZenohAddress
from voa_client._zenoh_link import config, zenoh_library

if TYPE_CHECKING:
    import zenoh


class NoRouter(VoaClientError):
    """No Zenoh router accepted the connection."""


def address_of(text: str) -> ZenohAddress:
    """Parse a router's address as a person writes it: a `zenoh://` URL or an endpoint; raises UsageError."""
    scheme, is_url, _ = text.partition("://")
    if scheme in SCHEMES if is_url else text.partition("/")[0] in ENDPOINTS:
        return ZenohAddress.parse(text)
    known = ", ".join(f"{scheme}://" for scheme in SCHEMES)
    raise UsageError(f"expected a URL with {known} or a Zenoh endpoint like tcp/127.0.0.1:7447, got {text!r}")


@contextmanager
def joined(address: ZenohAddress, open_ms: int = 0, more: Mapping[str, Any] | None = None) -> Iterator["zenoh.Session"]:
    """Open a session with a router for the length of a `with`; it reconnects by itself when the router was away.

    Args:
        address: of the router, with the user to connect as.
        open_ms: time to wait for the router, milliseconds; 0: try once.
        more: further entries of Zenoh's configuration, by path.

    Raises:
        NoRouter: no router answers there, or it refuses the credentials: Zenoh does not say which.
        MissingLibraryError: Zenoh's library is not installed.
    """
    library = zenoh_library()
    if "RUST_LOG" in os.environ:  # Zenoh logs to stdout, so it stays silent unless it is wanted
        library.init_log_from_env_or("error")
    try:
        session = library.open(config(address, open_ms, more or {}))
    except library.ZError as error:
        raise NoRouter(
            f"no Zenoh router accepted the connection to {address.endpoint}: it is not running, or refuses the "
            "credentials; `voa doctor` finds out which"
        ) from error
    try:
        yield session
    finally:
        session.close()
