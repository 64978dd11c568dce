"""What the service has heard of robots: one report each, so that no scan is lost in silence."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from voa_msgs import examples
from voa_msgs.base import Id, Message
from voa_msgs.examples import exemplified
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.warnings import ProbableMistake


class LookReport(Message):
    """A look of a robot, and what the session made of it."""

    at: datetime
    """When it was applied, by the service's clock."""
    sensor: str | None
    """The sensor configuration where it was taken; null: at a pose."""
    sensor_pose: UncertainSensorPose | None
    """The lidar's pose where it was taken; null: at a sensor configuration."""
    accepted: bool
    reason: str | None
    """Kind of update, or why the look was not accepted; as in the answer to a scan."""
    version: int
    """Version of the session after it."""


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
    """The condition for the next look of a mapped robot that is not met yet; null where each scan is a look."""
    last_look: LookReport | None = None
    """The newest look that this process applied, and its result; null: none yet."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in how the robot is used, and those of its newest look's answer."""


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
