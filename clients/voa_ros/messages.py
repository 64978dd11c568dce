"""The three ROS 2 messages that matter here, as far as they matter; plain numbers, SI units.

Field for field they are `sensor_msgs/msg/LaserScan`, `nav_msgs/msg/Odometry` and
`geometry_msgs/msg/PoseWithCovarianceStamped`. Each refuses (ValueError) what no driver would mean: that is how a
payload of another type, whose bytes happen to fit, is told from a scan.
"""

import math
from dataclasses import dataclass

NANOSECONDS = 1_000_000_000
FARTHEST_M = 1e5
"""No robot is farther from the origin of its map."""
_MOST_ANGLE_RAD = 100.0
_LEAST_INCREMENT_RAD = 1e-6
_UNIT_WITHIN = 0.1
_MOST_TURNS = 1.05
"""Of a scan: drivers whose motor is a little fast or slow write a few beams more than a turn has."""

Covariance = tuple[float, ...]
"""36 numbers, row by row: x, y, z and the rotations about them."""


@dataclass(frozen=True, order=True)
class Stamp:
    """A time by the clock of the robot (or of its simulation)."""

    sec: int = 0
    nanosec: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.nanosec < NANOSECONDS:
            raise ValueError(f"nanosec: expected 0 to 999999999, got {self.nanosec}")

    @property
    def seconds(self) -> float:
        """The same in seconds; good to a microsecond for the times of this century."""
        return self.sec + self.nanosec / NANOSECONDS

    @classmethod
    def of(cls, seconds: float) -> "Stamp":
        """The stamp nearest to a time in seconds."""
        sec, nanosec = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
        return cls(sec, nanosec)


@dataclass(frozen=True)
class LaserScan:
    """One revolution of a planar lidar: beam `i` points to `angle_min + i * angle_increment`.

    Attributes:
        stamp: when the first ray was taken, says ROS; some drivers stamp after the revolution.
        angle_min, angle_max, angle_increment: radians, counter-clockwise about z, 0 along the lidar's +x; the
            increment may be negative. `angle_max` is not always true: trust the other two.
        time_increment, scan_time: seconds between beams and between scans; whatever the driver says.
        range_min, range_max: metres; what lies outside is to be discarded.
        ranges: metres; inf: nothing in range, -inf: too close, NaN: erroneous (REP-117). At least one.
        intensities: empty, or in units of the device.

    Raises:
        ValueError: it cannot be a scan; the message says what was expected.
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
    """Say where the angles in a scan's header contradict one another; None: nowhere.

    `angle_max` is not always true, so only its side of `angle_min` is looked at, and the beams must fit one turn, or
    nearly so.
    """
    low, high, step, beams = scan.angle_min, scan.angle_max, scan.angle_increment, len(scan.ranges)
    if (high - low) * step < 0.0 and abs(high - low) > _LEAST_INCREMENT_RAD:
        grow, fall = ("grow", "fall") if high > low else ("fall", "grow")
        return (
            f"angle_min {low:.6g} and angle_max {high:.6g} say that the angles {grow}, angle_increment {step:.6g} says "
            f"that they {fall}: one of them is wrong, and with it left and right; correct the driver's settings "
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
    """Position in metres and orientation as a quaternion.

    Raises:
        ValueError: a position that is none, or a quaternion that is not of unit length.
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
        """A pose on the floor."""
        return cls((x, y, 0.0), (0.0, 0.0, math.sin(yaw_rad / 2.0), math.cos(yaw_rad / 2.0)))

    @property
    def yaw_rad(self) -> float:
        """Rotation about z, in (-pi, pi]; of a tilted pose, the direction of its +x seen from above."""
        x, y, z, w = self.quaternion_xyzw
        return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


@dataclass(frozen=True)
class Twist:
    """Velocities in m/s and rad/s, in the robot's own frame."""

    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)


NO_COVARIANCE: Covariance = (0.0,) * 36


@dataclass(frozen=True)
class PoseWithCovariance:
    """Where the robot is in its map, as AMCL says it."""

    stamp: Stamp
    frame_id: str
    pose: Pose
    covariance: Covariance = NO_COVARIANCE


@dataclass(frozen=True)
class Odometry:
    """Where the robot is in its odometry frame, and how it moves."""

    stamp: Stamp
    frame_id: str
    child_frame_id: str
    pose: Pose
    covariance: Covariance = NO_COVARIANCE
    twist: Twist = Twist()
    twist_covariance: Covariance = NO_COVARIANCE
