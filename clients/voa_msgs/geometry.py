"""Where sensors stand."""

from voa_msgs.base import Free, Message, Name, NotNegative, Real


class SensorPose(Message):
    """The lidar's own pose in the world frame (z up, the table at z = 0)."""

    x: Real
    """Metres."""
    y: Real
    """Metres."""
    yaw_rad: Real
    """Direction of beam angle 0, counter-clockwise from the world's +x."""
    height_m: Real | None = None
    """Height of the scan plane over the table; null: the lidar's."""


class SensorConfiguration(SensorPose):
    """A place from which the lidar can look."""

    name: Name
    cost: NotNegative = 0.0
    """What it costs to look from here, in success probability."""
    data: Free = None
    """The user's own; kept and returned."""


class CandidateSensor(SensorPose):
    """A sensor pose to be ranked; without a name it is called by its index, "0", "1", ..."""

    name: Name | None = None
    cost: NotNegative = 0.0


class PoseUncertainty(Message):
    """Standard deviations of a sensor pose that is only roughly known."""

    xy_m: NotNegative = 0.0
    yaw_rad: NotNegative = 0.0


class UncertainSensorPose(SensorPose):
    """A sensor pose, as well as it is known."""

    std: PoseUncertainty | None = None
