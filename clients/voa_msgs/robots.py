"""What the service has heard of robots: one report each, so that no scan is lost in silence."""

from datetime import datetime
from typing import Literal

from voa_msgs import examples
from voa_msgs.base import Id, Message
from voa_msgs.examples import exemplified


class RobotReport(Message):
    """A robot, as this process of the service has heard it since it started."""

    robot: str
    session: str | None
    """Session that its scans are for, a mapped robot's even before its first look; null: nobody's, or not known."""
    source: Literal["scan", "ros2"]
    """Put on `scan/<session>/<robot>`, or a ROS 2 topic that is mapped."""
    key: str
    """Of the newest sample, or the expression that is listened to."""
    last_scan_at: datetime | None
    """By the service's clock; null: none yet."""
    scans: int
    """Heard."""
    looks: int
    """Of those, or of their medians: applied to the session, accepted or not."""
    refused: int
    """Could not be used."""
    last_refusal: str | None
    """Why, of the newest."""
    waiting_for: str | None
    """What a mapped topic waits for until its scans are a look."""


class Robots(Message):
    """All robots that were heard or are mapped, by name."""

    items: list[RobotReport]
    mapping_error: str | None = None
    """Why the mapping in force is not the one that its file has."""


class LookRequest(Message):
    """The next scans of a robot are to be a look (mode `on_request`)."""

    robot: str


class ClaimRequest(Message):
    """Say whose session a mapped robot's scans are for from now on."""

    model_config = exemplified(examples.CLAIM)

    session: Id | None
    """Null: nobody's, until the next claim."""
