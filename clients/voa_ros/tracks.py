"""The newest poses of a robot by time, whatever its clock does."""

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter

from voa_ros.clocks import ClockOffset
from voa_ros.motions import wrapped

MOST_POSES = 1_024
"""Kept of each track: five seconds of the fastest odometry."""
CLOCKS_APART_S = 0.5
"""Stamps whose clocks, compared at arrival, differ by more are not compared with one another."""
COPY_WITHIN_S = 0.5
"""A pose that arrives twice, by two bridges, does so within this; later, its stamp says that a clock was set back."""


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
        self._arrived: list[float] = []
        """When each of the poses was received first."""
        self._offset = ClockOffset()
        self._last: RobotPose | None = None
        self._received_s = -math.inf

    @property
    def newest(self) -> RobotPose | None:
        """The latest by its own time."""
        return self._poses[-1] if self._poses else None

    def receive(self, pose: RobotPose, received_s: float) -> bool:
        """Take a pose; of two with one stamp the later received holds.

        Args:
            pose: by the robot's clock.
            received_s: when it arrived, by any steady clock.

        Returns:
            Whether the robot's clock was set back: the poses of later times are void then.
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
        """Whether a clock is that of the poses, by what it is behind the clock that messages arrive by."""
        own_s = self._offset.seconds
        return own_s is None or offset_s is None or abs(offset_s - own_s) <= CLOCKS_APART_S

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
        """The pose that was received last, for a scan whose stamp says nothing.

        Args:
            received_s: when the scan arrived.
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
