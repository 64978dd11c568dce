"""Sensor poses: in a scenario, in a ranking request, and with a scan."""

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from voa_msgs.base import Free, Message, Name, NotNegative, Real


class SensorPose(Message):
    """Pose of the lidar itself (not of its robot) in the world frame: z up, the table at z = 0."""

    x: Real
    """X coordinate of the lidar, metres."""
    y: Real
    """Y coordinate of the lidar, metres."""
    yaw_rad: Real
    """Yaw of the lidar, radians: direction of beam angle 0, counter-clockwise from the world's +x."""
    height_m: Real | None = None
    """Height of the scan plane above the table, metres; null: the height of the scenario's lidar."""


class SensorConfiguration(SensorPose):
    """Sensor configuration: a named pose from which the lidar can look."""

    name: Name
    """Name of the sensor configuration, unique in the scenario."""
    cost: NotNegative = 0.0
    """Cost of a look from here, in units of success probability; it is subtracted from the VOA."""
    data: Free = None
    """Any JSON of the user's own; the service stores it and returns it unchanged."""


class CandidateSensor(SensorPose):
    """Sensor pose to be ranked that the scenario does not list."""

    name: Name | None = None
    """Name of the sensor pose in the response; null: its index in the request, "0", "1", ..."""
    cost: NotNegative = 0.0
    """Cost of a look from here, in units of success probability; it is subtracted from the VOA."""


class Location(Message):
    """Point on the floor, in the world frame."""

    x: Real
    """X coordinate, metres."""
    y: Real
    """Y coordinate, metres."""


def _form(sensor: Any) -> str:
    return "name" if isinstance(sensor, str) else "pose"


Candidate = Annotated[Annotated[Name, Tag("name")] | Annotated[CandidateSensor, Tag("pose")], Discriminator(_form)]
"""Name of a sensor configuration of the scenario, or any sensor pose."""
Departure = Annotated[Annotated[Name, Tag("name")] | Annotated[Location, Tag("pose")], Discriminator(_form)]
"""Name of a sensor configuration of the scenario, or a point on the floor."""


class PoseUncertainty(Message):
    """Standard deviations of a sensor pose that is not exactly known."""

    xy_m: NotNegative = 0.0
    """Standard deviation of x, and of y, metres."""
    yaw_rad: NotNegative = 0.0
    """Standard deviation of the yaw, radians."""


class Spread(Message):
    """Standard deviations of the object about a listed pose, in the plane of the table; at least one is above 0."""

    xy_m: NotNegative = 0.0
    """Standard deviation of x, and of y, metres."""
    yaw_rad: NotNegative = 0.0
    """Standard deviation of the yaw about the position of the pose, radians."""


class UncertainSensorPose(SensorPose):
    """Sensor pose with its uncertainty."""

    std: PoseUncertainty | None = None
    """Standard deviations of the pose; null: the pose is exactly known."""
