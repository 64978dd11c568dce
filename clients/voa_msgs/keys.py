"""Zenoh key expressions of the service, and the attachment that accompanies a payload.

Keys below a root, whose last chunk is the name of the lab:

| key                         | use                                                                              |
|-----------------------------|----------------------------------------------------------------------------------|
| `scan/<session>/<robot>`    | put: a raw scan, as `application/json` (`sessions.ScanRequest`) or `application/cdr` |
| `rpc/<method>`              | query: the body of the HTTP request, plus the `session` or `id` of its path       |
| `belief/<session>`          | put after each commit: the session, its version attached; delete when it ends    |
| `refused/<session>/<robot>` | put for each scan that could not be used: a problem document                     |
| `replica/<id>`              | liveliness token of each process of the service                                  |
"""

import re
from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import Field, StringConstraints, model_validator

from voa_msgs.base import Message, Name
from voa_msgs.geometry import UncertainSensorPose

ROOT = "voa/v1/default"
"""Root of all keys, unless the service is configured with another."""
CHUNK = re.compile(r"[A-Za-z0-9_.-]+")
"""Pattern of one chunk of a key."""

IdempotencyId = Annotated[str, StringConstraints(min_length=1, max_length=255, pattern=r"^[^\x00]*$")]


def check_root(root: str) -> str:
    """Return the root; raises ValueError unless it is chunks of `[A-Za-z0-9_.-]` separated by slashes."""
    if not all(CHUNK.fullmatch(chunk) for chunk in root.split("/")):
        raise ValueError(
            f"expected a root like {ROOT!r}: chunks of letters, digits, '_', '.', '-', separated by '/', got {root!r}"
        )
    return root


@dataclass(frozen=True)
class Keys:
    """Keys below a root; with `*` as a name they are the key expression that matches every name."""

    root: str = ROOT

    def scan(self, session: str, robot: str) -> str:
        """Key on which a robot puts its scans for a session."""
        return f"{self.root}/scan/{session}/{robot}"

    def rpc(self, method: str) -> str:
        """Key on which a method is called."""
        return f"{self.root}/rpc/{method}"

    def belief(self, session: str) -> str:
        """Key on which the service publishes each new version of a session."""
        return f"{self.root}/belief/{session}"

    def refused(self, session: str, robot: str) -> str:
        """Key on which the service reports that a robot's scan could not be used, and why."""
        return f"{self.root}/refused/{session}/{robot}"

    def replica(self, id_: str) -> str:
        """Key of the liveliness token of a process of the service."""
        return f"{self.root}/replica/{id_}"

    def last(self, key: str) -> str:
        """Return the last chunk of a key: the method of an `rpc`, the session of a `belief`, the id of a `replica`."""
        return key.rpartition("/")[2]


class Attachment(Message):
    """Attachment of a put or of a call by Zenoh, as JSON; every field is optional."""

    id: IdempotencyId | None = None
    """Idempotency key: a call that is repeated with it gets the first response, and changes nothing."""
    sensor: Name | None = None
    """Sensor configuration at which a scan was taken, if the payload does not state it."""
    sensor_pose: UncertainSensorPose | None = None
    """Pose of the lidar at which a scan was taken, if the payload does not state it."""
    key: str | None = Field(default=None, repr=False)
    """API key of the caller."""
    wire: int | None = None
    """Version of the messages that the caller uses."""

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if self.sensor is not None and self.sensor_pose is not None:
            raise ValueError("at most one of 'sensor' and 'sensor_pose' is expected")
        return self
