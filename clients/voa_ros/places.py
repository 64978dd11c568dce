"""Where the lidar was when a scan was taken, from what the robot says of itself.

Three planar poses follow one another: the lidar on the robot (`Mount`), the robot in the frame of its odometry or map
(`PoseTrack`, `Localisation`), that frame in the world (`PlanarPose`, the mapping's `origin`).

The time of a scan is the middle of its revolution. Times are the robot's own, in seconds: scans and poses are
stamped by one clock, or cannot be brought together here.
"""

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Literal, Protocol

from voa_msgs.base import MOST
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance
from voa_ros.robots import AmclPlace, Mount, OdometryPlace, PlanarPose, RobotMapping

MOST_POSES = 1_024
"""Kept of each track: five seconds of the fastest odometry."""
BACK_S = 5.0
"""A pose that is older than the newest by more means that the robot's clock was set back: what came before is void."""
_LONGEST_REVOLUTION_S = 2.0
_DIGITS = 9


class Planar(Protocol):
    """Anything that says where it is on the floor."""

    @property
    def x(self) -> float:
        """Metres."""

    @property
    def y(self) -> float:
        """Metres."""

    @property
    def yaw_rad(self) -> float:
        """Counter-clockwise."""


@dataclass(frozen=True)
class Motion:
    """A frame in another: metres and radians."""

    x: float
    y: float
    yaw_rad: float


@dataclass(frozen=True)
class RobotPose:
    """The robot in the frame of its odometry or map.

    Attributes:
        at_s: when, by the robot's clock.
        x, y: metres.
        yaw_rad: radians.
        variance_xy_m2, variance_yaw: of AMCL's covariance, x and y averaged; 0 where it does not say.
    """

    at_s: float
    x: float
    y: float
    yaw_rad: float
    variance_xy_m2: float = 0.0
    variance_yaw: float = 0.0


@dataclass(frozen=True)
class NoPose:
    """It is not known where the robot was."""

    reason: str


def wrapped(angle_rad: float) -> float:
    """The same direction in [-pi, pi]."""
    return math.remainder(angle_rad, math.tau)


def composed(frame: Planar, inside: Planar) -> Motion:
    """The pose of what is at `inside` in a frame, where the frame is at `frame`."""
    cos, sin = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    return Motion(
        x=frame.x + cos * inside.x - sin * inside.y,
        y=frame.y + sin * inside.x + cos * inside.y,
        yaw_rad=wrapped(frame.yaw_rad + inside.yaw_rad),
    )


def inverse(pose: Planar) -> Motion:
    """The pose of the outer frame in the inner one."""
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return Motion(x=-cos * pose.x - sin * pose.y, y=sin * pose.x - cos * pose.y, yaw_rad=wrapped(-pose.yaw_rad))


def middle_s(scan: LaserScan, stamp: Literal["first_ray", "after_revolution"]) -> float:
    """The middle of a revolution, in seconds by the robot's clock.

    A `scan_time` that is no time of a revolution (the LDS-01's driver divides by a speed that may be 0) counts as 0.
    """
    half = scan.scan_time / 2.0 if 0.0 <= scan.scan_time <= _LONGEST_REVOLUTION_S else 0.0
    return scan.stamp.seconds + (half if stamp == "first_ray" else -half)


def robot_pose(message: Odometry | PoseWithCovariance) -> RobotPose:
    """What a message says; variances that are none (negative, infinite, NaN) count as not said."""
    covariance = message.covariance
    return RobotPose(
        message.stamp.seconds,
        message.pose.position[0],
        message.pose.position[1],
        message.pose.yaw_rad,
        _variance((covariance[0] + covariance[7]) / 2.0),
        _variance(covariance[35]),
    )


def _variance(value: float) -> float:
    return min(value, MOST) if 0.0 < value < math.inf else 0.0


class PoseTrack:
    """The newest poses of one robot, by time. They may come late, twice, and after the clock was set back."""

    def __init__(self, max_age_s: float, what: str = "pose", most: int = MOST_POSES) -> None:
        """An empty track.

        Args:
            max_age_s: a pose tells where the robot was as long before or after.
            what: its name in reasons.
            most: how many are kept.
        """
        self._max_age_s = max_age_s
        self._what = what
        self._most = most
        self._poses: list[RobotPose] = []

    @property
    def newest(self) -> RobotPose | None:
        """The latest by its own time."""
        return self._poses[-1] if self._poses else None

    def hear(self, pose: RobotPose) -> None:
        """Take a pose in; of two with one stamp the later heard holds."""
        if self._poses and pose.at_s < self._poses[-1].at_s - BACK_S:
            self._poses.clear()
        index = bisect.bisect_left(self._poses, pose.at_s, key=_AT)
        same = index < len(self._poses) and self._poses[index].at_s == pose.at_s
        self._poses[index : index + same] = [pose]
        del self._poses[: -self._most]

    def at(self, at_s: float) -> RobotPose | NoPose:
        """Where the robot was.

        Between two poses that are near enough to each other, on the straight line from one to the other and turning the
        short way; else at the nearest, if that is not too far.

        Args:
            at_s: seconds by the robot's clock.
        """
        index = bisect.bisect_left(self._poses, at_s, key=_AT)
        around = self._poses[max(index - 1, 0) : index + 1]
        if not around:
            return NoPose(f"no {self._what} was heard yet")
        if len(around) == 2 and around[1].at_s - around[0].at_s <= 2.0 * self._max_age_s:
            return _between(around[0], around[1], at_s)
        nearest = min(around, key=lambda pose: abs(pose.at_s - at_s))
        off = at_s - nearest.at_s
        if abs(off) > self._max_age_s:
            apart = f"{abs(off):.3g} s {'older' if off > 0.0 else 'newer'} than the scan"
            return NoPose(f"the nearest {self._what} is {apart}: expected at most {self._max_age_s:g} s")
        return replace(nearest, at_s=at_s)


_AT: Callable[[RobotPose], float] = attrgetter("at_s")


def _between(one: RobotPose, other: RobotPose, at_s: float) -> RobotPose:
    share = (at_s - one.at_s) / (other.at_s - one.at_s)
    return RobotPose(
        at_s,
        one.x + share * (other.x - one.x),
        one.y + share * (other.y - one.y),
        wrapped(one.yaw_rad + share * wrapped(other.yaw_rad - one.yaw_rad)),
        max(one.variance_xy_m2, other.variance_xy_m2),
        max(one.variance_yaw, other.variance_yaw),
    )


@dataclass(frozen=True)
class _Correction:
    """AMCL's pose, and the odometry's of the same time."""

    amcl: RobotPose
    odometry: RobotPose

    def carried(self, now: RobotPose) -> RobotPose:
        """Where the robot is in the map, now that the odometry has gone on."""
        pose = composed(self.amcl, composed(inverse(self.odometry), now))
        variances = self.amcl.variance_xy_m2, self.amcl.variance_yaw
        return RobotPose(now.at_s, pose.x, pose.y, pose.yaw_rad, *variances)


class Localisation:
    """Where one robot's lidar was, from its odometry and, by AMCL, from its map."""

    def __init__(self, place: OdometryPlace | AmclPlace, mount: Mount) -> None:
        """Nothing heard yet.

        Args:
            place: as the mapping says.
            mount: the lidar on the robot.
        """
        self._place = place
        self._mount = mount
        self._odometry = PoseTrack(place.max_age_s, "odometry")
        self._heard: RobotPose | None = None
        self._correction: _Correction | None = None

    def hear_odometry(self, message: Odometry) -> None:
        """Take in what the odometry says."""
        pose = robot_pose(message)
        newest = self._odometry.newest
        if newest is not None and pose.at_s < newest.at_s - BACK_S:
            self._correction = None  # of another time, and after a restart of the simulation of another odometry
        self._odometry.hear(pose)
        self._correct()

    def hear_amcl(self, message: PoseWithCovariance) -> None:
        """Take in what AMCL says; it holds as soon as the odometry of its time is there."""
        self._heard = robot_pose(message)
        self._correct()

    def _correct(self) -> None:
        newest = self._odometry.newest
        if self._heard is None or newest is None or newest.at_s < self._heard.at_s:
            return
        odometry = self._odometry.at(self._heard.at_s)
        if isinstance(odometry, RobotPose):
            self._correction = _Correction(self._heard, odometry)
        self._heard = None

    def at(self, at_s: float) -> UncertainSensorPose | NoPose:
        """The lidar in the world at a time by the robot's clock."""
        now = self._odometry.at(at_s)
        if isinstance(now, RobotPose) and isinstance(self._place, AmclPlace):
            now = self._in_map(now, self._place)
        if isinstance(now, NoPose):
            return now
        if isinstance(self._place, OdometryPlace):
            now = replace(now, variance_xy_m2=0.0, variance_yaw=0.0)  # an odometry's say nothing of the world
        return lidar_pose(now, self._mount, self._place.origin, self._place.std)

    def _in_map(self, now: RobotPose, place: AmclPlace) -> RobotPose | NoPose:
        if self._correction is None:
            return NoPose("no AMCL pose was heard yet whose odometry is known")
        carried = math.hypot(now.x - self._correction.odometry.x, now.y - self._correction.odometry.y)
        if carried > place.max_carried_m:
            return NoPose(
                f"AMCL's newest pose is {carried:.3g} m back by odometry: expected at most {place.max_carried_m:g} m"
            )
        return self._correction.carried(now)


def localisation(robot: RobotMapping) -> Localisation | None:
    """What a mapping needs; None where the lidar's place is named, not measured."""
    return Localisation(robot.place, robot.lidar) if isinstance(robot.place, OdometryPlace | AmclPlace) else None


def lidar_pose(
    robot: RobotPose, mount: Mount, origin: PlanarPose, std: PoseUncertainty | None = None
) -> UncertainSensorPose:
    """The lidar's pose in the world: `origin * robot * mount`.

    Args:
        robot: in the frame of its odometry or map.
        mount: the lidar on the robot.
        origin: that frame in the world.
        std: of the lidar's pose; None: from the robot's variances. Those of x and y are averaged, so that the
            frame's rotation does not matter; a lidar off the robot's centre adds what the uncertain yaw moves it.
    """
    pose = composed(composed(origin, robot), mount)
    if std is None and (robot.variance_xy_m2 > 0.0 or robot.variance_yaw > 0.0):
        lever_m2 = mount.x**2 + mount.y**2
        xy = math.sqrt(robot.variance_xy_m2 + robot.variance_yaw * lever_m2 / 2.0)
        std = PoseUncertainty(xy_m=min(xy, MOST), yaw_rad=math.sqrt(robot.variance_yaw))
    return UncertainSensorPose(
        x=round(pose.x, _DIGITS),
        y=round(pose.y, _DIGITS),
        yaw_rad=round(pose.yaw_rad, _DIGITS),
        height_m=mount.height_m,
        std=std,
    )
