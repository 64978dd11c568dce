"""Track of the newest poses of a robot by time, which tolerates late, repeated and set-back stamps."""

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter

from voa_ros.clocks import ClockOffset
from voa_ros.motions import wrapped

MOST_POSES = 1_024
"""Number of poses that a track keeps: five seconds of the fastest odometry."""
CLOCKS_APART_S = 0.5
"""Largest offset of two clocks, seconds, with which their stamps are compared."""
COPY_WITHIN_S = 0.5
"""Time, seconds, within which a pose with an equal stamp is a repetition; later, the clock was set back."""


@dataclass(frozen=True)
class RobotPose:
    """Pose of the robot in the frame of its odometry or map.

    Attributes:
        at_s: time, seconds by the robot's clock.
        x, y: position, metres.
        yaw_rad: yaw, radians.
        variance_xy_m2: mean of AMCL's variances of x and y, m^2; 0: unknown.
        variance_yaw: AMCL's variance of the yaw, rad^2; 0: unknown.
    """

    at_s: float
    x: float
    y: float
    yaw_rad: float
    variance_xy_m2: float = 0.0
    variance_yaw: float = 0.0


@dataclass(frozen=True)
class NoPose:
    """Result where the pose is not known, with the reason in words."""

    reason: str


class PoseTrack:
    """Newest poses of one robot, by time; poses may arrive late, twice, or after the clock was set back."""

    def __init__(self, max_age_s: float, what: str = "pose", most: int = MOST_POSES) -> None:
        """Start with no pose.

        Args:
            max_age_s: seconds before and after its time for which a pose is used.
            what: name of the poses in reasons.
            most: number of poses that are kept.
        """
        self._max_age_s = max_age_s
        self._what = what
        self._most = most
        self._poses: list[RobotPose] = []
        self._arrived: list[float] = []
        """Time at which each of the poses was first received, seconds."""
        self._offset = ClockOffset()
        self._last: RobotPose | None = None
        self._received_s = -math.inf

    @property
    def newest(self) -> RobotPose | None:
        """Pose with the latest stamp; None: there is none."""
        return self._poses[-1] if self._poses else None

    def receive(self, pose: RobotPose, received_s: float) -> bool:
        """Add a pose; it replaces a pose with the same stamp.

        Args:
            pose: pose, with its time by the robot's clock.
            received_s: time of arrival, seconds by any steady clock.

        Returns:
            True if the robot's clock was set back, so that the poses of later times were removed.
        """
        index = bisect.bisect_left(self._poses, pose.at_s, key=_AT)
        same = index < len(self._poses) and self._poses[index].at_s == pose.at_s
        copy = same and received_s - self._arrived[index] <= COPY_WITHIN_S
        back = not copy and bool(self._poses) and pose.at_s < self._poses[-1].at_s - self._max_age_s
        replaced = slice(index, len(self._poses) if back else index + same)
        if not copy:
            self._offset.receive(pose.at_s, received_s)
        self._arrived[replaced] = [self._arrived[index] if copy else received_s]
        self._poses[replaced] = [pose]
        del self._poses[: -self._most], self._arrived[: -self._most]
        if self._poses[-1] is pose:
            self._last, self._received_s = pose, received_s
        return back

    def agrees(self, offset_s: float | None) -> bool:
        """True if a clock with this offset to the receiver's clock, seconds, is the clock of the poses."""
        own_s = self._offset.seconds
        return own_s is None or offset_s is None or abs(offset_s - own_s) <= CLOCKS_APART_S

    def at(self, at_s: float) -> RobotPose | NoPose:
        """Return the pose of the robot at a time.

        Between two poses that are close enough in time, the pose is interpolated linearly, with the yaw along the
        shorter turn; otherwise it is the pose nearest in time, if that is not too old.

        Args:
            at_s: time, seconds by the robot's clock.
        """
        index = bisect.bisect_left(self._poses, at_s, key=_AT)
        around = self._poses[max(index - 1, 0) : index + 1]
        if not around:
            return self._none()
        if len(around) == 2 and around[1].at_s - around[0].at_s <= 2.0 * self._max_age_s:
            return _between(around[0], around[1], at_s)
        nearest = min(around, key=lambda pose: abs(pose.at_s - at_s))
        off = at_s - nearest.at_s
        if abs(off) > self._max_age_s:
            apart = f"{abs(off):.3g} s {'older' if off > 0.0 else 'newer'} than the scan"
            return NoPose(f"the nearest {self._what} is {apart}: expected at most {self._max_age_s:g} s")
        return replace(nearest, at_s=at_s)

    def latest(self, received_s: float) -> RobotPose | NoPose:
        """Return the pose that was received last, for a scan whose stamp cannot be used.

        Args:
            received_s: time of arrival of the scan, seconds.
        """
        if self._last is None:
            return self._none()
        ago = received_s - self._received_s
        if ago > 2.0 * self._max_age_s:
            return NoPose(
                f"the scan's stamp does not fit the clock of the {self._what}, and the newest {self._what} came "
                f"{ago:.3g} s before the scan: expected at most {2.0 * self._max_age_s:g} s"
            )
        return self._last

    def _none(self) -> NoPose:
        return NoPose(f"no {self._what} was received yet")


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
