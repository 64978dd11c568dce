"""Decide when the scans of a robot become a look.

A lidar turns five times a second. A robot that is parked for a minute sends 300 scans with the same errors of its pose
and of the surface. A belief that took each of them for new evidence would be certain, and perhaps wrong, within a
second. So the revolutions are gathered into *looks*, each of which updates the belief once. The mode of a robot decides
when:

`every`: each scan is a look. For a robot that never stops, or a sensor that publishes a scan only on purpose.

`stationary`: the robot stops, and the per-beam median of `scans` revolutions is the look; there is no other look until
it has moved on. Each stop gives one look.

`on_request`: there is no look until `request()`; then the median of the next `scans` revolutions for which the robot
stands still.

The place of the robot decides if it stands still, and if it has moved on:

- With a measured pose (odometry, AMCL, or a pose in the attachment), it stands still while it is less than `still_xy_m`
  and `still_yaw_rad` from the previous revolution *and* from the first one of the stop, so that slow creeping ends a
  stop too. It has moved on when three successive revolutions are farther than `moved_xy_m` or `moved_yaw_rad` from the
  place of the look: one wrong pose does not cause a second look.
- With the name of a sensor configuration there is no pose, and the scans themselves are compared (`voa_ros.scenes`).
  Their median difference is insensitive to a person who walks by, as long as less than half of the scene is hidden, and
  to lost packets and beams that return intermittently. The robot has moved on when as many successive revolutions as a
  look has, at least five, differ from the look by *twice* the tolerance for one scene. Another name is another place at
  once. This cannot detect a move of a centimetre or two, nor one that ends where it began before so many revolutions.

The beams of the revolutions may differ in number and angles; they are then brought onto the grid of the scenario's
lidar. A scan without a pose neither continues nor ends a stop.

**A look that was not accepted** (all beams missing, the object not seen, no pose that fits) does not use up the stop or
the request: after `rejected()`, the next revolutions make another look.

**After a restart** the robot may still be parked at the place of its look. `resume()` gets the newest look of this
robot from the session's history; a robot at that place, or with that scene, has had the look of this stop. Other
processes receive the same scans: pass every look of this robot that the session gets to `resume()`, whichever process
took it.

This module uses no clock: only revolutions are counted.
"""

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.grids import BeamGrid, aligned
from voa_ros.looks import GatheredLook, Revolution, Waiting, Where, look_of
from voa_ros.messages import LaserScan
from voa_ros.motions import within
from voa_ros.robots import LookRule
from voa_ros.scans import laser_scan
from voa_ros.scenes import CLEARLY, scene_difference
from voa_ros.tracks import NoPose

AWAY_BY_POSE = 3
"""Successive revolutions, by measured pose, after which a robot has moved on."""
AWAY_BY_SCENE = 5
"""Fewest successive revolutions, by comparison of scans, after which a robot has moved on."""
PARKED = 10
"""Successive looks from one place, in mode `every`, that show a parked robot."""

MOVE_ON = "the robot to move on: this stop's look is taken"
"""Condition for the next look after the look of a stop."""


class LookTaker:
    """State machine that gathers the revolutions of one robot into looks."""

    def __init__(self, robot: str, rule: LookRule, grid: BeamGrid) -> None:
        """Start with no revolution.

        Args:
            robot: name of the robot, which its looks contain.
            rule: rule by which scans become looks.
            grid: grid of the scenario's lidar, for revolutions whose beams differ.
        """
        self._robot = robot
        self._rule = rule
        self._grid = grid
        self._stop: list[Revolution] = []
        self._taken: Revolution | None = None
        self._away = 0
        self._parked = 0
        self._requested = False
        self._resumed: ScanRequest | None = None
        self._rejected: str | None = None
        self._waiting_for: str | None = "a request" if rule.mode == "on_request" else "a scan"

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet, in words; None where each scan is a look."""
        return self._waiting_for

    @property
    def requested(self) -> bool:
        """True if a look was requested and not taken yet."""
        return self._requested

    @property
    def standing(self) -> int:
        """Number of revolutions of the present stop so far."""
        return len(self._stop)

    @property
    def parked(self) -> bool:
        """True if each scan is a look while the robot does not move, so that the belief becomes falsely certain."""
        return self._parked >= PARKED

    def request(self) -> None:
        """Request a look from the next revolutions for which the robot stands still.

        Raises:
            ValueError: the mode of the robot is not `on_request`.
        """
        if self._rule.mode != "on_request":
            raise ValueError(f"expected a robot in mode 'on_request', {self._robot!r} is in mode {self._rule.mode!r}")
        self._requested = True
        self._rejected = None
        self._stop.clear()
        self._waiting_for = "the robot to stop"

    def resume(self, request: ScanRequest) -> None:
        """Register the newest look of this robot in the session, whether this process took it or another.

        A robot that is still at its place has had the look of this stop. (This matters in mode `stationary` only.)
        Registering a look twice changes nothing.
        """
        if request != self._resumed:
            self._note(request)

    def _note(self, request: ScanRequest) -> None:
        where = request.sensor if request.sensor is not None else request.sensor_pose
        if where is not None:
            self._resumed = request
            self._taken = Revolution(laser_scan(request.scan, self._grid), where)
            self._away = 0

    def rejected(self, reason: str, request: ScanRequest | None = None) -> None:
        """Let the next revolutions make another look, because the last one was not accepted.

        Args:
            reason: reason in a few words, for `waiting_for`.
            request: look that was not accepted; None: the newest. If the robot has moved on or has had another look in
                the meantime, nothing changes.
        """
        stationary = self._rule.mode == "stationary"
        if stationary and (self._taken is None or (request is not None and request != self._resumed)):
            return
        self._rejected = reason
        self._taken = None
        self._resumed = None
        self._away = 0
        self._stop.clear()
        if self._rule.mode == "on_request":
            self._requested = True
        if self._rule.mode != "every":
            self._wait(self._progress())

    def receive(self, scan: LaserScan, where: Where | NoPose) -> GatheredLook | Waiting:
        """Add a revolution, in the order of arrival.

        Args:
            scan: scan of the revolution.
            where: pose of the lidar in the middle of it, or the name of the sensor configuration; NoPose: unknown.

        Returns:
            A look, or the condition for the next look that is not met yet.
        """
        if isinstance(where, NoPose):
            return self._wait(f"the lidar's pose: {where.reason}")
        revolution = Revolution(scan, where)
        match self._rule.mode:
            case "every":
                self._waiting_for = None
                self._count_parked(revolution)
                return look_of(self._robot, [revolution], self._grid)
            case "on_request" if not self._requested:
                return self._wait("a request")
            case "stationary" if self._taken is not None and not self._moved_on(revolution, self._taken):
                return self._wait(MOVE_ON)
        return self._gather(revolution)

    def _wait(self, reason: str) -> Waiting:
        self._waiting_for = reason
        return Waiting(reason)

    def _count_parked(self, revolution: Revolution) -> None:
        """Count the successive looks from one place, in mode `every`."""
        still = self._taken is not None and self._stands(revolution, self._taken)
        self._parked = self._parked + 1 if still else 1
        if not still:
            self._taken = revolution

    def _moved_on(self, revolution: Revolution, taken: Revolution) -> bool:
        """Count the successive revolutions away from the look; return True, and forget the look, when they suffice."""
        away, enough = self._is_away(revolution, taken)
        self._away = self._away + 1 if away else 0
        if self._away < enough:
            return False
        self._taken = None
        self._rejected = None
        self._away = 0
        self._stop.clear()
        return True

    def _is_away(self, revolution: Revolution, taken: Revolution) -> tuple[bool, int]:
        """Return True if a revolution is away from the place of the look, and how many successive ones are a move."""
        match revolution.where, taken.where:
            case UncertainSensorPose() as here, UncertainSensorPose() as there:
                return not within(here, there, self._rule.moved_xy_m, self._rule.moved_yaw_rad), AWAY_BY_POSE
            case str(here), str(there) if here == there:
                return self._difference(revolution, taken) > CLEARLY, max(AWAY_BY_SCENE, self._rule.scans)
            case _:
                return True, 1

    def _gather(self, revolution: Revolution) -> GatheredLook | Waiting:
        if self._stop and not all(self._stands(revolution, other) for other in (self._stop[-1], self._stop[0])):
            self._stop.clear()
            self._rejected = None
        self._stop.append(revolution)
        if len(self._stop) < self._rule.scans:
            return self._wait(self._progress())
        look = look_of(self._robot, self._stop, self._grid)
        self._note(look.request)  # even if it equals the previous look, as it may without stamps and noise
        self._stop.clear()
        self._requested = False
        self._wait("a request" if self._rule.mode == "on_request" else MOVE_ON)
        return look

    def _progress(self) -> str:
        """Describe the progress of the look of this stop, and why the previous look does not count."""
        standing, again = len(self._stop), f"; the last look was not accepted ({self._rejected})"
        reached = f"standing still: {standing} of {self._rule.scans} revolutions"
        return (reached if standing > 1 else "the robot to stop") if self._rejected is None else reached + again

    def _stands(self, revolution: Revolution, other: Revolution) -> bool:
        match revolution.where, other.where:
            case UncertainSensorPose() as here, UncertainSensorPose() as there:
                return within(here, there, self._rule.still_xy_m, self._rule.still_yaw_rad)
            case here, there:
                return here == there and self._difference(revolution, other) <= 1.0

    def _difference(self, one: Revolution, other: Revolution) -> float:
        return scene_difference(*aligned(one.scan, other.scan, self._grid))
