"""Place of the lidar in the mapping of a robot: its mount, and the source of the poses at which scans are taken."""

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import AfterValidator, Field

from voa_msgs.base import MOST, Message, Name, Real
from voa_msgs.geometry import PoseUncertainty
from voa_ros.messages import FARTHEST_M
from voa_ros.topics import resolve

Coordinate = Annotated[float, Ge(-FARTHEST_M), Le(FARTHEST_M)]
"""Coordinate of a frame, metres."""
Yaw = Annotated[float, Ge(-100.0), Le(100.0)]
"""Yaw of a frame, radians, counter-clockwise."""
Tolerance = Annotated[float, Gt(0.0), Le(MOST)]
"""Distance in metres, or angle in radians, above 0."""
Seconds = Annotated[float, Gt(0.0), Le(MOST)]
"""Duration, seconds, above 0."""


def check_topic_name(topic: str) -> str:
    """Return the topic; raises InvalidTopic unless it is a relative or absolute ROS topic."""
    resolve("", topic)
    return topic


Topic = Annotated[str, AfterValidator(check_topic_name)]
"""ROS topic: relative to the namespace of the robot, or absolute with a leading slash."""


class PlanarPose(Message):
    """Pose of a frame in another frame, in the plane of the floor."""

    x: Coordinate = 0.0
    """X coordinate, metres."""
    y: Coordinate = 0.0
    """Y coordinate, metres."""
    yaw_rad: Yaw = 0.0
    """Yaw, radians, counter-clockwise."""


class Mount(PlanarPose):
    """Pose of the lidar in the base frame of the robot."""

    height_m: Real | None = None
    """Height of the scan plane above the table, metres; null: the height of the scenario's lidar."""
    upside_down: bool = False
    """True if the lidar hangs upside down (rolled over about its +x axis), so that its angles count clockwise."""


class SensorPlace(Message):
    """Source of poses: the lidar stands at a sensor configuration of the scenario."""

    source: Literal["sensor"] = Field(alias="from")
    """Always `sensor`."""
    sensor: Name
    """Name of the sensor configuration."""


class AttachmentPlace(Message):
    """Source of poses: the attachment of each scan states where it was taken."""

    source: Literal["attachment"] = Field(alias="from")
    """Always `attachment`."""


class OdometryPlace(Message):
    """Source of poses: the odometry of the robot, from a known origin."""

    source: Literal["odometry"] = Field(alias="from")
    """Always `odometry`."""
    topic: Topic = "odom"
    """Topic of the odometry."""
    origin: PlanarPose = PlanarPose()
    """Pose of the odometry frame in the world frame."""
    std: PoseUncertainty | None = None
    """Standard deviations of the lidar's pose; null: the pose is exactly known."""
    max_age_s: Seconds = 0.2
    """Largest difference, in seconds, between the times of a scan and of the pose that is used for it."""


class AmclPlace(Message):
    """Source of poses: AMCL's pose in a map, carried forward by odometry.

    AMCL publishes only after the robot has moved by its `update_min_d` (0.25 m). With AMCL's newest pose alone, a robot
    that creeps would seem to stand still, and the pose of a parked robot would be old. So each pose of AMCL corrects
    the odometry instead.
    """

    source: Literal["amcl"] = Field(alias="from")
    """Always `amcl`."""
    topic: Topic = "amcl_pose"
    """Topic of AMCL's poses."""
    odometry: Topic = "odom"
    """Topic of the odometry."""
    origin: PlanarPose = PlanarPose()
    """Pose of the map frame in the world frame."""
    std: PoseUncertainty | None = None
    """Standard deviations of the lidar's pose; null: they are taken from AMCL's covariance."""
    max_age_s: Seconds = 0.2
    """Largest difference, in seconds, between the times of a scan and of the odometry that is used for it."""
    max_carried_m: Tolerance = 1.0
    """Largest distance, metres, over which odometry carries AMCL's newest pose; beyond it AMCL counts as lost."""


Place = Annotated[SensorPlace | AttachmentPlace | OdometryPlace | AmclPlace, Field(discriminator="source")]
"""Source of the poses at which scans are taken."""
