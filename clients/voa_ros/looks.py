"""When the scans of a robot are a look.

A lidar turns five times a second. A robot that is parked for a minute sends 300 scans that all say the same thing, with
the same errors of its pose and of the surface. A belief that took each of them for new evidence would be certain, and
perhaps wrong, within a second. So scans are gathered into *looks*, one update of the belief each:

`every`: each scan is a look. For a robot that never stops, or a sensor that sends a scan only when it means one.

`stationary`: the robot stops, and the per-beam median of `scans` revolutions is the look; then nothing more until it
has moved on. One stop, one look.

`on_request`: nothing until `request()`; then the median of the next `scans` revolutions for which it stands still.

Does it stand still, and has it moved on? By what is known of its place:

- A measured pose (odometry, AMCL, an attachment's pose): it stands still while it is less than `still_xy_m` and
  `still_yaw_rad` from the revolution before *and* from the first of the stop, so that slow creeping ends a stop too.
  It has moved on when three revolutions in a row are farther than `moved_xy_m` or `moved_yaw_rad` from where the look
  was taken: one pose that is off makes no second look.
- A sensor configuration's name: there is no pose to go by, but the scene itself. Two scans show one scene when, over
  the beams that return in both, the median difference is within the lidar's noise (2 cm and 4 % of the range: an
  LDS-01 is good for 3.5 %), and no more than a quarter of the beams changed their class (return, nothing, zero). A
  median takes no notice of somebody who walks by, as long as he hides less than half of what is seen; nor of a lost
  packet. It has moved on when as many revolutions in a row as a look has, five at least, differ from the look by
  *twice* that. Another name is another place at once. What this cannot see: a move of a centimetre or two, and one
  that ends where it began before so many revolutions are over.

A revolution that comes twice (by two bridges, say) counts once. Scans without a pose count neither way. A driver that
changes its number of beams from turn to turn has no median: the stop begins anew with each change.

**After a restart** the robot may still be parked where its look was taken. `resume()` is told the newest look that the
session's history has of this robot, and a robot found at that place, or seeing that scene, has had its look of this
stop. Other processes hear the same scans: tell `resume()` every look of this robot that the session gets, whoever took
it. Looks have deterministic names for the rest: of one robot, the same times and ranges are the same look.

Nothing here knows a clock: what counts is revolutions.
"""

import hashlib
import math
import statistics
import struct
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import Scan, ScanRequest
from voa_ros.messages import LaserScan, Stamp
from voa_ros.places import NoPose, wrapped
from voa_ros.robots import LookRule
from voa_ros.scans import beam_class, median_scan, same_grid, scan_message, stamp_json

NOISE_M = 0.02
NOISE_SHARE = 0.04
"""Of the range. Two scans of one scene differ by less than `NOISE_M + NOISE_SHARE * range`, in the median."""
CHANGED_SHARE = 0.25
"""Of the beams: as many may change their class within one scene."""
CLEARLY = 2.0
"""A scene is clearly another when it differs by as many times what one scene may."""
AWAY_BY_POSE = 3
AWAY_BY_SCENE = 5
"""Revolutions in a row until a robot has moved on."""
_REMEMBERED = 16

Where = UncertainSensorPose | str
"""A pose of the lidar in the world, or the name of one of the scenario's sensor configurations."""


@dataclass(frozen=True)
class Taken:
    """A look.

    Attributes:
        name: the same wherever the same revolutions are heard: the update's idempotency id.
        request: the update. Its scan's `stamp` is `{"robot", "from", "to", "scans", "frame_id"}`.
    """

    name: str
    request: ScanRequest


@dataclass(frozen=True)
class Waiting:
    """No look yet."""

    reason: str


@dataclass(frozen=True)
class _Revolution:
    scan: LaserScan
    where: Where


@dataclass(frozen=True)
class _Reference:
    """Where a look was taken, and what it saw."""

    where: Where
    ranges: tuple[float, ...]


def robot_of(request: ScanRequest) -> str | None:
    """The robot whose look a session's history holds; None where it is not one that was taken here."""
    stamp = request.scan.stamp
    robot = stamp.get("robot") if isinstance(stamp, dict) else None
    return robot if isinstance(robot, str) else None


class LookTaker:
    """Gathers the scans of one robot into looks."""

    def __init__(self, robot: str, rule: LookRule) -> None:
        """Nothing heard yet.

        Args:
            robot: its name, which its looks carry.
            rule: when scans are a look.
        """
        self._robot = robot
        self._rule = rule
        self._stop: list[_Revolution] = []
        self._taken: _Reference | None = None
        self._away = 0
        self._requested = False
        self._heard: deque[tuple[Stamp, bytes]] = deque(maxlen=_REMEMBERED)
        self._told: ScanRequest | None = None
        self._waiting_for: str | None = "a request" if rule.mode == "on_request" else "a scan"

    @property
    def waiting_for(self) -> str | None:
        """What has to happen until there is a look, in words; None where each scan is one, and its pose known."""
        return self._waiting_for

    @property
    def requested(self) -> bool:
        """Whether a look was asked for and not taken yet."""
        return self._requested

    def request(self) -> None:
        """The next revolutions for which the robot stands still are to be a look.

        Raises:
            ValueError: looks are not taken on request.
        """
        if self._rule.mode != "on_request":
            raise ValueError(f"expected a robot in mode 'on_request', {self._robot!r} is in mode {self._rule.mode!r}")
        self._requested = True
        self._stop.clear()
        self._waiting_for = "the robot to stop"

    def resume(self, request: ScanRequest) -> None:
        """A look of this robot that the session has: the newest one, taken by this process or another.

        A robot that is still there has had its look of this stop. (It matters in mode `stationary` alone.) To be told
        the same look again changes nothing.
        """
        where = request.sensor if request.sensor is not None else request.sensor_pose
        if where is not None and request != self._told:
            self._told = request
            self._taken = _Reference(where, _ranges(request.scan))
            self._away = 0

    def heard(self, scan: LaserScan, where: Where | NoPose) -> Taken | Waiting:
        """Take a revolution in, in the order in which they come.

        Args:
            scan: the revolution.
            where: the lidar's pose in the middle of it, or the sensor configuration where it stands.
        """
        if self._repeats(scan):
            return Waiting("a scan that was not heard before")
        if isinstance(where, NoPose):
            return self._wait(f"the lidar's pose: {where.reason}")
        revolution = _Revolution(scan, where)
        match self._rule.mode:
            case "every":
                self._waiting_for = None
                return self._look([revolution])
            case "on_request" if not self._requested:
                return self._wait("a request")
            case "stationary" if self._taken is not None and not self._moved_on(revolution, self._taken):
                return self._wait("the robot to move on: this stop's look is taken")
        return self._gather(revolution)

    def _repeats(self, scan: LaserScan) -> bool:
        """Whether this very revolution was heard already. Without a clock (stamp 0) none can be told from the next."""
        if scan.stamp == Stamp():
            return False
        key = (scan.stamp, _digest(scan.ranges))
        if key in self._heard:
            return True
        self._heard.append(key)
        return False

    def _wait(self, reason: str) -> Waiting:
        self._waiting_for = reason
        return Waiting(reason)

    def _moved_on(self, revolution: _Revolution, taken: _Reference) -> bool:
        """Counts the revolutions away from the look, and forgets the look when they are enough."""
        away, enough = self._is_away(revolution, taken)
        self._away = self._away + 1 if away else 0
        if self._away < enough:
            return False
        self._taken = None
        self._away = 0
        self._stop.clear()
        return True

    def _is_away(self, revolution: _Revolution, taken: _Reference) -> tuple[bool, int]:
        """Whether a revolution is not where the look was taken, and how many such in a row are a move."""
        match revolution.where, taken.where:
            case UncertainSensorPose() as here, UncertainSensorPose() as there:
                return not _within(here, there, self._rule.moved_xy_m, self._rule.moved_yaw_rad), AWAY_BY_POSE
            case str(here), str(there) if here == there:
                enough = max(AWAY_BY_SCENE, self._rule.scans)
                return scene_difference(revolution.scan.ranges, taken.ranges) > CLEARLY, enough
            case _:
                return True, 1

    def _gather(self, revolution: _Revolution) -> Taken | Waiting:
        if self._stop and not all(self._stands(revolution, other) for other in (self._stop[-1], self._stop[0])):
            self._stop.clear()
        self._stop.append(revolution)
        count = len(self._stop)
        if count == 1:
            return self._wait("the robot to stop")
        if count < self._rule.scans:
            return self._wait(f"standing still: {count} of {self._rule.scans} revolutions")
        look = self._look(self._stop)
        self.resume(look.request)
        self._stop.clear()
        self._requested = False
        self._wait(
            "a request" if self._rule.mode == "on_request" else "the robot to move on: this stop's look is taken"
        )
        return look

    def _stands(self, revolution: _Revolution, other: _Revolution) -> bool:
        if not same_grid(revolution.scan, other.scan):
            return False
        match revolution.where, other.where:
            case UncertainSensorPose() as here, UncertainSensorPose() as there:
                return _within(here, there, self._rule.still_xy_m, self._rule.still_yaw_rad)
            case here, there:
                return here == there and scene_difference(revolution.scan.ranges, other.scan.ranges) <= 1.0

    def _look(self, revolutions: Sequence[_Revolution]) -> Taken:
        scans = [revolution.scan for revolution in revolutions]
        first, last = scans[0].stamp, scans[-1].stamp
        stamp: dict[str, Any] = {
            "robot": self._robot,
            "from": stamp_json(first),
            "to": stamp_json(last),
            "scans": len(scans),
            "frame_id": scans[0].frame_id,
        }
        median = median_scan(scans)
        where = _middle([revolution.where for revolution in revolutions])
        request = ScanRequest(
            sensor=where if isinstance(where, str) else None,
            sensor_pose=None if isinstance(where, str) else where,
            scan=scan_message(median, stamp),
        )
        name = f"{self._robot}:{first.sec}.{first.nanosec:09}:{last.sec}.{last.nanosec:09}"
        return Taken(f"{name}:{_digest(median.ranges).hex()}", request)  # times come again where a simulation restarts


def _within(one: UncertainSensorPose, other: UncertainSensorPose, xy_m: float, yaw_rad: float) -> bool:
    near = math.hypot(one.x - other.x, one.y - other.y) <= xy_m
    return near and abs(wrapped(one.yaw_rad - other.yaw_rad)) <= yaw_rad


def _middle(places: Sequence[Where]) -> Where:
    """The mean of poses that lie close together; of a name, the name."""
    first = places[0]
    poses = [place for place in places if isinstance(place, UncertainSensorPose)]
    if isinstance(first, str) or len(poses) == 1:
        return first
    turned = statistics.fmean(wrapped(pose.yaw_rad - first.yaw_rad) for pose in poses)
    return first.model_copy(
        update={
            "x": statistics.fmean(pose.x for pose in poses),
            "y": statistics.fmean(pose.y for pose in poses),
            "yaw_rad": wrapped(first.yaw_rad + turned),
        }
    )


def scene_difference(one: Sequence[float], other: Sequence[float]) -> float:
    """How much two scans of the same beams differ, in units of what two scans of one scene may.

    The larger of two: the median over the beams that return in both of `|a - b| / (NOISE_M + NOISE_SHARE * min(a, b))`;
    and, of the beams that are missing in neither, the share that changed their class, over `CHANGED_SHARE`. Infinite
    where the numbers of beams differ, or no beam can be compared.
    """
    if len(one) != len(other):
        return math.inf
    apart: list[float] = []
    compared = changed = 0
    for a, b in zip(one, other, strict=True):
        here, there = beam_class(a), beam_class(b)
        if here == "missing" or there == "missing":
            continue
        compared += 1
        if here != there:
            changed += 1
        elif here == "return":
            apart.append(abs(a - b) / (NOISE_M + NOISE_SHARE * min(a, b)))
    if not compared:
        return math.inf
    return max(statistics.median(apart) if apart else 0.0, changed / compared / CHANGED_SHARE)


def _ranges(scan: Scan) -> tuple[float, ...]:
    """As the LaserScan had them."""
    nothing = set(scan.no_return)
    return tuple(
        math.inf if index in nothing else math.nan if value is None else value
        for index, value in enumerate(scan.ranges)
    )


def _digest(ranges: Sequence[float]) -> bytes:
    return hashlib.blake2b(struct.pack(f"<{len(ranges)}d", *ranges), digest_size=16).digest()
