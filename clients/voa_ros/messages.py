"""Values of three ROS 2 messages: LaserScan, Odometry and PoseWithCovarianceStamped; plain numbers in SI units.

Their fields are those of `sensor_msgs/msg/LaserScan`, `nav_msgs/msg/Odometry` and
`geometry_msgs/msg/PoseWithCovarianceStamped`. Each raises ValueError for values that no driver would publish: this
detects a payload of another type whose bytes happen to fit.
"""

import math
from dataclasses import dataclass

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""
FARTHEST_M = 1e5
"""Largest distance of a robot from the origin of its map, metres."""
_MOST_ANGLE_RAD = 100.0
_LEAST_INCREMENT_RAD = 1e-6
_UNIT_WITHIN = 0.1
_MOST_TURNS = 1.05
"""Most turns in one scan: drivers whose motor is a little slow write a few beams more than a turn has."""

Covariance = tuple[float, ...]
"""Covariance matrix, 36 numbers row by row: x, y, z (m^2) and the rotations about them (rad^2)."""


@dataclass(frozen=True, order=True)
class Stamp:
    """Stamp of a message: a time by the clock of the robot or of its simulation."""

    sec: int = 0
    nanosec: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.nanosec < NANOSECONDS:
            raise ValueError(f"nanosec: expected 0 to 999999999, got {self.nanosec}")

    @property
    def seconds(self) -> float:
        """Time of the stamp in seconds, exact to a microsecond for the times of this century."""
        return self.sec + self.nanosec / NANOSECONDS

    @classmethod
    def of(cls, seconds: float) -> "Stamp":
        """Return the stamp nearest to a time in seconds."""
        sec, nanosec = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
        return cls(sec, nanosec)


@dataclass(frozen=True)
class LaserScan:
    """Scan of a planar lidar: beam `i` points to `angle_min + i * angle_increment`.

    Attributes:
        stamp: time of the first ray by the standard of ROS; some drivers stamp after the revolution.
        frame_id: frame of the lidar.
        angle_min, angle_max, angle_increment: radians, counter-clockwise about z, 0 along the lidar's +x; the
            increment may be negative. `angle_max` is wrong in some drivers and not used.
        time_increment, scan_time: seconds between beams and between scans, as the driver states them.
        range_min, range_max: limits of the sensor, metres; ranges outside of them are to be discarded.
        ranges: metres, at least one; inf: nothing in range, -inf: too close, NaN: erroneous (REP-117).
        intensities: empty, or in units of the device.

    Raises:
        ValueError: the values cannot be those of a scan; the error says what was expected.
    """

    stamp: Stamp
    frame_id: str
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: tuple[float, ...]
    intensities: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not abs(self.angle_min) <= _MOST_ANGLE_RAD:
            raise ValueError(f"angle_min: expected an angle in radians, got {self.angle_min}")
        if not _LEAST_INCREMENT_RAD <= abs(self.angle_increment) <= math.tau * 1.001:
            raise ValueError(
                f"angle_increment: expected radians between beams, at most a turn and not 0, got {self.angle_increment}"
            )
        returns = any(0.0 < value < math.inf for value in self.ranges)  # limits of a picoScan's empty segments differ
        ordered = self.range_min <= self.range_max if returns else self.range_max >= 0.0
        if not (self.range_min >= 0.0 and math.isfinite(self.range_min) and ordered):
            raise ValueError(
                f"range_min, range_max: expected 0 <= range_min <= range_max, got {self.range_min} and {self.range_max}"
            )
        if not self.ranges:
            raise ValueError("ranges: expected at least one beam, got none")


def header_contradiction(scan: LaserScan) -> str | None:
    """Describe how the angles in the header of a scan contradict one another; None: they do not.

    `angle_max` is wrong in some drivers, so only its sign relative to `angle_min` is compared with the increment. The
    beams must fit into about one turn.
    """
    low, high, step, beams = scan.angle_min, scan.angle_max, scan.angle_increment, len(scan.ranges)
    if (high - low) * step < 0.0 and abs(high - low) > _LEAST_INCREMENT_RAD:
        grow, fall = ("grow", "fall") if high > low else ("fall", "grow")
        return (
            f"angle_min {low:.6g} and angle_max {high:.6g} say that the angles {grow}, angle_increment {step:.6g} says "
            f"that they {fall}: one of them is wrong, and left and right may be swapped; correct the driver's settings "
            "(`reversed`, `inverted`)"
        )
    turns = beams * abs(step) / math.tau
    if turns > max(_MOST_TURNS, 1.0 + 1.5 * abs(step) / math.tau):
        return (
            f"{beams} beams of angle_increment {step:.6g} rad are {turns:.3g} turns: expected at most one turn, with "
            "angles in radians"
        )
    return None


@dataclass(frozen=True)
class Pose:
    """Pose of a frame: position in metres and orientation as a quaternion.

    Raises:
        ValueError: the position is not finite or too far away, or the quaternion has not unit length.
    """

    position: tuple[float, float, float]
    quaternion_xyzw: tuple[float, float, float, float]

    def __post_init__(self) -> None:
        if not all(abs(value) <= FARTHEST_M for value in self.position):
            raise ValueError(f"position: expected metres within {FARTHEST_M:g} of the origin, got {self.position}")
        if not abs(sum(value * value for value in self.quaternion_xyzw) - 1.0) <= _UNIT_WITHIN:
            raise ValueError(f"orientation: expected a quaternion of length 1, got {self.quaternion_xyzw}")

    @classmethod
    def planar(cls, x: float, y: float, yaw_rad: float) -> "Pose":
        """Return the pose of a frame on the floor: x and y in metres, yaw in radians."""
        return cls((x, y, 0.0), (0.0, 0.0, math.sin(yaw_rad / 2.0), math.cos(yaw_rad / 2.0)))

    @property
    def yaw_rad(self) -> float:
        """Yaw, radians, in (-pi, pi]: the direction of +x seen from above."""
        x, y, z, w = self.quaternion_xyzw
        return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


@dataclass(frozen=True)
class Twist:
    """Velocities of a robot in its own frame, m/s and rad/s."""

    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)


NO_COVARIANCE: Covariance = (0.0,) * 36
"""Covariance of a message that states none."""


@dataclass(frozen=True)
class PoseWithCovariance:
    """Pose of the robot in its map with a covariance, as AMCL publishes it."""

    stamp: Stamp
    frame_id: str
    pose: Pose
    covariance: Covariance = NO_COVARIANCE


@dataclass(frozen=True)
class Odometry:
    """Pose of the robot in its odometry frame, and its velocities."""

    stamp: Stamp
    frame_id: str
    child_frame_id: str
    pose: Pose
    covariance: Covariance = NO_COVARIANCE
    twist: Twist = Twist()
    twist_covariance: Covariance = NO_COVARIANCE
