"""Caller of the service, as it is known by its API key."""

from datetime import datetime
from typing import Literal

from voa_msgs.base import Message

Role = Literal["sensor", "arm", "viewer", "operator"]
"""Role of a caller: `sensor` sends scans and announces looks, `arm` reports outcomes of grasps, `viewer` reads, and
`operator` may do everything; all of them read."""


class Caller(Message):
    """Caller of the service, with what it may do: for programs that hide what they may not."""

    name: str
    """Name of the caller's key; `anonymous` where the service has no keys."""
    role: Role
    """Role of the caller's key; `operator` where the service has no keys."""
    key: str | None
    """Identifier of the key, which is no secret; null: the service has no keys."""
    sessions: list[str] | None
    """Identifiers of the only sessions that the key is for; null: any."""
    robots: list[str] | None
    """Names of the only robots that the key is for; null: any."""
    expires_at: datetime | None
    """Time from which the key is no longer valid, UTC; null: never."""
    calls: list[str]
    """Names of the calls that the role may make, such as `scan.apply`, sorted."""
