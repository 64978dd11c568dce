"""Pose of the lidar at the time of a scan, from the odometry of the robot or from AMCL.

Three planar poses are composed: the lidar on the robot (`Mount`), the robot in the frame of its odometry or map
(`PoseTrack`, `Localisation`), and that frame in the world (`PlanarPose`, the mapping's `origin`).

The time of a scan is the middle of its revolution. Scans and poses are associated by their stamps, in seconds by the
robot's own clock, as long as these are plausible. Stamps of 0, stamps that are frozen or set back, and stamps of two
clocks that differ by more than half a second do not give the time of a scan. Such a scan gets the newest pose, if that
was received shortly before it.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

from voa_msgs.base import MOST
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose
from voa_ros.clocks import ClockOffset
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance
from voa_ros.motions import composed, inverse, wrapped
from voa_ros.robot_places import AmclPlace, Mount, OdometryPlace, PlanarPose
from voa_ros.robots import RobotMapping
from voa_ros.tracks import NoPose, PoseTrack, RobotPose

JUMP_M = 0.1
"""Jump, metres, of an odometry that is set back in time, above which it has restarted in a new frame."""
JUMP_RAD = 0.2
"""Jump, radians, of an odometry that is set back in time, above which it has restarted in a new frame."""
_LONGEST_REVOLUTION_S = 2.0
_DIGITS = 9


def middle_s(scan: LaserScan, stamp: Literal["first_ray", "after_revolution"]) -> float:
    """Return the time of the middle of a revolution, in seconds by the robot's clock.

    An implausible `scan_time` (the LDS-01's driver divides by a speed that may be 0) counts as 0.
    """
    half = scan.scan_time / 2.0 if 0.0 <= scan.scan_time <= _LONGEST_REVOLUTION_S else 0.0
    return scan.stamp.seconds + (half if stamp == "first_ray" else -half)


def robot_pose(message: Odometry | PoseWithCovariance) -> RobotPose:
    """Read the planar pose from a message; variances that are negative, infinite or NaN become 0, unknown."""
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


@dataclass(frozen=True)
class _Correction:
    """Pose of AMCL, and pose of the odometry at the same time."""

    amcl: RobotPose
    odometry: RobotPose

    def carried(self, now: RobotPose) -> RobotPose:
        """Carry AMCL's pose forward to the odometry's pose `now`; returns the pose of the robot in the map."""
        pose = composed(self.amcl, composed(inverse(self.odometry), now))
        variances = self.amcl.variance_xy_m2, self.amcl.variance_yaw
        return RobotPose(now.at_s, pose.x, pose.y, pose.yaw_rad, *variances)


class Localisation:
    """Localisation of one robot's lidar by its odometry and, in a map, by AMCL."""

    def __init__(self, place: OdometryPlace | AmclPlace, mount: Mount) -> None:
        """Start with no pose.

        Args:
            place: source of the poses, from the mapping.
            mount: pose of the lidar on the robot.
        """
        self._place = place
        self._mount = mount
        self._odometry = PoseTrack(place.max_age_s, "odometry")
        self._amcl: tuple[RobotPose, float] | None = None
        """AMCL's newest pose and its time of arrival, until the odometry of its time is received."""
        self._correction: _Correction | None = None
        self._scans = ClockOffset()

    def receive_odometry(self, message: Odometry, received_s: float) -> None:
        """Add a pose of the odometry, with its time of arrival in seconds by any steady clock."""
        pose = robot_pose(message)
        before = self._odometry.newest
        set_back = self._odometry.receive(pose, received_s)
        if set_back and before is not None and _jumps(before, pose):
            self._forget_map()
        self._correct()

    def receive_amcl(self, message: PoseWithCovariance, received_s: float) -> None:
        """Add a pose of AMCL; it is used as soon as the odometry of its time has been received.

        AMCL publishes only when the robot has moved by its `update_min_d`. A latched pose of a robot that has been
        parked for hours is older than any odometry that was received; it counts as the present pose of the robot.
        """
        self._amcl = robot_pose(message), received_s
        self._correct()

    def _forget_map(self) -> None:
        """Forget AMCL's poses, because a simulation has restarted and its odometry has a new frame."""
        self._correction = None
        if self._amcl is not None and not self._odometry.agrees(self._amcl[1] - self._amcl[0].at_s):
            self._amcl = None

    def _correct(self) -> None:
        newest = self._odometry.newest
        if self._amcl is None or newest is None:
            return
        amcl, received_s = self._amcl
        awaited = newest.at_s < amcl.at_s
        if awaited and self._odometry.agrees(received_s - amcl.at_s):
            return
        odometry = self._odometry.at(amcl.at_s)
        if awaited or isinstance(odometry, NoPose):
            odometry = newest
        self._correction = _Correction(amcl, odometry)
        self._amcl = None

    def at(self, at_s: float | None, received_s: float) -> UncertainSensorPose | NoPose:
        """Return the pose of the lidar in the world at the time of a scan.

        Args:
            at_s: time of the scan, seconds by the robot's clock; None: its stamp cannot be used.
            received_s: time of arrival of the scan, seconds by the clock by which the poses were received.
        """
        now = self._in_odometry(at_s, received_s)
        if isinstance(now, RobotPose) and isinstance(self._place, AmclPlace):
            now = self._in_map(now, self._place)
        if isinstance(now, NoPose):
            return now
        if isinstance(self._place, OdometryPlace):
            now = replace(
                now, variance_xy_m2=0.0, variance_yaw=0.0
            )  # the variances of an odometry are not those of the pose in the world
        return lidar_pose(now, self._mount, self._place.origin, self._place.std)

    def _in_odometry(self, at_s: float | None, received_s: float) -> RobotPose | NoPose:
        """Return the pose by odometry: at the stamp of the scan where that is plausible, else the newest pose."""
        if at_s is None:
            return self._odometry.latest(received_s)
        self._scans.receive(at_s, received_s)
        if not self._odometry.agrees(self._scans.seconds):
            return self._odometry.latest(received_s)
        pose, newest = self._odometry.at(at_s), self._odometry.newest
        if isinstance(pose, NoPose) and newest is not None and newest.at_s < at_s:
            latest = self._odometry.latest(received_s)  # the clocks are a little apart, or the odometry is slow
            return latest if isinstance(latest, RobotPose) else pose
        return pose

    def _in_map(self, now: RobotPose, place: AmclPlace) -> RobotPose | NoPose:
        if self._correction is None:
            return NoPose(f"no AMCL pose was received yet on {place.topic}")
        carried = math.hypot(now.x - self._correction.odometry.x, now.y - self._correction.odometry.y)
        if carried > place.max_carried_m:
            return NoPose(
                f"the robot has driven {carried:.3g} m since AMCL's newest pose: "
                f"expected at most {place.max_carried_m:g} m"
            )
        return self._correction.carried(now)


def _jumps(one: RobotPose, other: RobotPose) -> bool:
    """True if two successive poses are too far apart for one odometry."""
    apart = math.hypot(one.x - other.x, one.y - other.y)
    return apart > JUMP_M or abs(wrapped(one.yaw_rad - other.yaw_rad)) > JUMP_RAD


def localisation(robot: RobotMapping) -> Localisation | None:
    """Make the localisation that a mapping needs; None: the mapping states the place of the lidar itself."""
    return Localisation(robot.place, robot.lidar) if isinstance(robot.place, OdometryPlace | AmclPlace) else None


def lidar_pose(
    robot: RobotPose, mount: Mount, origin: PlanarPose, std: PoseUncertainty | None = None
) -> UncertainSensorPose:
    """Compute the pose of the lidar in the world: `origin * robot * mount`.

    Args:
        robot: pose of the robot in the frame of its odometry or map.
        mount: pose of the lidar on the robot.
        origin: pose of that frame in the world.
        std: standard deviations of the lidar's pose; None: they follow from the variances of the robot. The variances
            of x and y are averaged, so that the rotation of the frame does not matter; for a lidar off the centre of
            the robot, the variance of the yaw adds to them.
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
