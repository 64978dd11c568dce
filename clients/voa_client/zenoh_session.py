"""A Zenoh session for the length of a command."""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import zenoh
import zenoh.ext
from zenoh.handlers import Callback

from voa_client import VoaClientError
from voa_client._errors import UsageError
from voa_client._zenoh_address import ENDPOINTS, SCHEMES, ZenohAddress
from voa_msgs.links import session_config


class NoRouter(VoaClientError):
    """No router took us."""


def address_of(text: str) -> ZenohAddress:
    """A router's address as a person writes it; raises UsageError."""
    scheme, is_url, _ = text.partition("://")
    if scheme in SCHEMES if is_url else text.partition("/")[0] in ENDPOINTS:
        return ZenohAddress.parse(text)
    known = ", ".join(f"{scheme}://" for scheme in SCHEMES)
    raise UsageError(f"expected a URL with {known} or a Zenoh endpoint like tcp/127.0.0.1:7447, got {text!r}")


@contextmanager
def joined(address: ZenohAddress, open_ms: int = 0, more: Mapping[str, Any] | None = None) -> Iterator[zenoh.Session]:
    """A session with the router at `address`; joins again by itself when the router was away.

    Args:
        address: which router, and as whom.
        open_ms: how long to wait for it; 0: one try.
        more: entries of Zenoh's configuration, by path.

    Raises:
        NoRouter: nobody is there, or it refuses the credentials: Zenoh does not say which.
    """
    if "RUST_LOG" in os.environ:  # Zenoh writes to stdout; without this it is mute
        zenoh.init_log_from_env_or("error")
    try:
        session = zenoh.open(_config(address, open_ms, more or {}))
    except zenoh.ZError as error:
        raise NoRouter(
            f"no Zenoh router took us at {address.endpoint}: it is not there, or refuses the credentials; "
            "`voa doctor` tells which"
        ) from error
    try:
        yield session
    finally:
        close: Any = session.close  # the stub leaves it untyped
        close()


def declare_latched_subscriber(session: zenoh.Session, expression: str, receive: "Callback[zenoh.Sample]") -> Any:
    """Subscribe to a key expression, and fetch the newest message that its publishers keep (transient local in ROS)."""
    history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
    return zenoh.ext.declare_advanced_subscriber(session, expression, receive, history=history)


def _config(address: ZenohAddress, open_ms: int, more: Mapping[str, Any]) -> zenoh.Config:
    config = zenoh.Config()
    entries = session_config([address.endpoint], address.user, address.password, open_ms)
    secure = {
        "root_ca_certificate": address.ca,
        "connect_certificate": address.cert,
        "connect_private_key": address.key,
    }
    link: dict[str, Any] = {name: file for name, file in secure.items() if file is not None}
    if link:
        entries["transport/link/tls"] = link | ({"enable_mtls": True} if address.cert is not None else {})
    for path, value in (entries | dict(more)).items():
        config.insert_json5(path, json.dumps(value))
    return config
