"""Where things are on Zenoh, and what travels beside a payload.

Below a root, whose last chunk is the lab:

| key                         | what                                                                             |
|-----------------------------|----------------------------------------------------------------------------------|
| `scan/<session>/<robot>`    | put: a raw scan, as `application/json` (`sessions.ScanRequest`) or `application/cdr` |
| `rpc/<method>`              | queryable: the body of the HTTP call, plus `session` or `id`                     |
| `belief/<session>`          | put after each commit: the session; attachment: its version; delete when it ends |
| `refused/<session>/<robot>` | put for each scan that could not be used: the problem                            |
| `replica/<id>`              | liveliness token of each process of the service                                  |
"""

import re
from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import StringConstraints, model_validator

from voa_msgs.base import Message, Name
from voa_msgs.geometry import UncertainSensorPose

ROOT = "voa/v1/default"
CHUNK = re.compile(r"[A-Za-z0-9_.-]+")

IdempotencyId = Annotated[str, StringConstraints(min_length=1, max_length=255, pattern=r"^[^\x00]*$")]


def check_root(root: str) -> str:
    """The root itself; raises ValueError unless it is chunks of `[A-Za-z0-9_.-]` with slashes between."""
    if not all(CHUNK.fullmatch(chunk) for chunk in root.split("/")):
        raise ValueError(f"expected a root like {ROOT!r}: chunks of letters, digits, '_', '.', '-', got {root!r}")
    return root


@dataclass(frozen=True)
class Keys:
    """The keys below a root; `*` as a name gives the expression for any."""

    root: str = ROOT

    def scan(self, session: str, robot: str) -> str:
        """Where a robot puts its scans for a session."""
        return f"{self.root}/scan/{session}/{robot}"

    def rpc(self, method: str) -> str:
        """Where a method is asked."""
        return f"{self.root}/rpc/{method}"

    def belief(self, session: str) -> str:
        """Where a session's versions appear."""
        return f"{self.root}/belief/{session}"

    def refused(self, session: str, robot: str) -> str:
        """Where it is told that a robot's scan could not be used."""
        return f"{self.root}/refused/{session}/{robot}"

    def replica(self, id_: str) -> str:
        """The token of a process of the service."""
        return f"{self.root}/replica/{id_}"

    def last(self, key: str) -> str:
        """The last chunk of a key: the method of an `rpc`, the session of a `belief`, the id of a `replica`."""
        return key.rpartition("/")[2]


class Attachment(Message):
    """Beside a put or an rpc, as JSON; everything in it is optional."""

    id: IdempotencyId | None = None
    """The caller's name for this call: sent again, it gets the first answer and changes nothing."""
    sensor: Name | None = None
    """Where a scan was taken, if its payload does not say: a sensor configuration of the scenario."""
    sensor_pose: UncertainSensorPose | None = None
    """The same: any pose of the lidar."""
    key: str | None = None
    """The API key."""
    wire: int | None = None
    """The version of the messages that the caller speaks."""

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if self.sensor is not None and self.sensor_pose is not None:
            raise ValueError("at most one of 'sensor' and 'sensor_pose' is expected")
        return self
