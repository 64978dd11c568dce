"""Reports about robots, requests for looks, and claims of robots by sessions."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from voa_msgs import examples
from voa_msgs.base import Id, Message
from voa_msgs.examples import exemplified
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import Scan
from voa_msgs.warnings import ProbableMistake


class LookReport(Message):
    """Look of a robot, and its effect on the session."""

    at: datetime
    """Time at which the look was applied to the session, by the clock of the service, UTC."""
    sensor: str | None
    """Sensor configuration from which the look was taken; null: `sensor_pose` states where."""
    sensor_pose: UncertainSensorPose | None
    """Pose of the lidar from which the look was taken; null: `sensor` states where."""
    accepted: bool
    """True if the look changed the belief of the session."""
    reason: str | None
    """Reason why the look was not accepted, or `nearest`, as `update.reason` of a scan's response; null: none."""
    version: int
    """Version of the session after the look."""


class Refusal(Message):
    """Refusal of scans or looks of a robot for one reason."""

    at: datetime
    """Time of the newest of them, by the clock of the service, UTC."""
    reason: str
    """Reason why they could not be used."""
    times: int = 1
    """Number of refusals in a row for this reason."""


class RobotReport(Message):
    """Report about a robot, from the scans that this process of the service has received since it started."""

    robot: str
    """Name of the robot."""
    session: str | None
    """Session to which the scans of the robot are applied; null: none, or not known yet. Scans that the robot may
    not put change nothing here."""
    source: Literal["scan", "ros2"]
    """Origin of its scans: puts on `scan/<session>/<robot>`, or a ROS 2 topic that a mapping names."""
    key: str
    """Key of the newest sample, or the key expression that is subscribed to."""
    last_scan_at: datetime | None
    """Time of the newest scan among `scans`, by the clock of the service, UTC; null: no scan yet."""
    scans: int
    """Number of scans received; of those that the robot puts, only scans that it may put."""
    looks: int
    """Number of looks applied to the session, accepted or not."""
    refused: int
    """Number of scans, and of looks, that could not be used."""
    last_refusal: str | None
    """Reason of the newest refusal; null: no refusal yet."""
    waiting_for: str | None
    """Condition for the next look of a mapped robot that is not met yet; null where each scan is a look."""
    last_look: LookReport | None = None
    """Newest look that this process applied, and its result; null: no look yet."""
    warnings: list[ProbableMistake] = Field(default=[])
    """Probable mistakes in the use of the robot, and those that its newest look caused; empty: none."""
    sensor: str | None = None
    """Sensor configuration at which its lidar was at the newest scan: the name that the mapping or the scan states, or
    the nearest listed one within 10 cm and 15 degrees of a measured pose; null: none, or not known."""
    sensor_pose: UncertainSensorPose | None = None
    """Pose of its lidar at the newest scan, with its uncertainty; null: not measured, or no scan yet."""
    gathered: int | None = None
    """Number of revolutions gathered for the next look; null where each scan is a look."""
    wanted: int | None = None
    """Number of revolutions that make a look; null where each scan is a look."""
    refusals: list[Refusal] = Field(default=[])
    """Newest refusals with their times, at most 5, the newest first; empty: none."""


class RobotScan(Message):
    """Newest scan of a robot that this process of the service could decode, whether it made a look or not."""

    robot: str
    """Name of the robot."""
    session: str | None
    """Session that the scan is for; null: none, or not known yet."""
    source: Literal["scan", "ros2"]
    """Origin of the scan: a put on `scan/<session>/<robot>`, or a ROS 2 topic that a mapping names."""
    at: datetime
    """Time at which the scan was received, by the clock of the service, UTC."""
    sensor: str | None
    """Sensor configuration from which it was taken; null: `sensor_pose` states where, or it is not known."""
    sensor_pose: UncertainSensorPose | None
    """Pose of the lidar from which it was taken; null: `sensor` states where, or it is not known."""
    scan: Scan
    """Scan as it is used: that of a lidar mapped as `upside_down` has counter-clockwise angles."""


class Robots(Message):
    """List of all robots whose scans were received, or whose topics are mapped."""

    items: list[RobotReport]
    """Reports, by name of the robot."""
    mapping_error: str | None = None
    """Reason why the mapping file cannot be used, so that the previous mapping is in use; null: the file is in use."""


class LookRequest(Message):
    """Request for a look: the next scans of a robot in mode `on_request` become a look."""

    robot: str
    """Name of the robot in the mapping."""


class ClaimRequest(Message):
    """Request to apply the scans of a mapped robot to a session from now on."""

    model_config = exemplified(examples.CLAIM)

    session: Id | None
    """Identifier of the session; null: the scans are applied to no session until the next claim."""
