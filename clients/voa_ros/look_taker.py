"""When the scans of a robot are a look.

A lidar turns five times a second. A robot that is parked for a minute sends 300 scans that all say the same thing, with
the same errors of its pose and of the surface. A belief that took each of them for new evidence would be certain, and
perhaps wrong, within a second. So scans are gathered into *looks*, one update of the belief each:

`every`: each scan is a look. For a robot that never stops, or a sensor that sends a scan only when it means one.

`stationary`: the robot stops, and the per-beam median of `scans` revolutions is the look; then nothing more until it
has moved on. One stop, one look.

`on_request`: nothing until `request()`; then the median of the next `scans` revolutions for which it stands still.

Whether it stands still, and whether it has moved on, is decided by what is known of its place:

- A measured pose (odometry, AMCL, an attachment's pose): it stands still while it is less than `still_xy_m` and
  `still_yaw_rad` from the revolution before *and* from the first of the stop, so that slow creeping ends a stop too.
  It has moved on when three revolutions in a row are farther than `moved_xy_m` or `moved_yaw_rad` from where the look
  was taken: one pose that is off makes no second look.
- A sensor configuration's name: there is no pose to go by, but the scene itself (`voa_ros.scenes`). A median over the
  beams takes no notice of somebody who walks by, as long as he hides less than half of what is seen; nor of lost
  packets and beams that answer now and then. It has moved on when as many revolutions in a row as a look has, five at
  least, differ from the look by *twice* what two scans of one scene may. Another name is another place at once. What
  this cannot see: a move of a centimetre or two, and one that ends where it began before so many revolutions are over.

The beams of the revolutions may differ in number and angles; they are then brought onto the grid of the scenario's
lidar. Scans without a pose count neither way.

**A look that was not accepted** (all beams missing, the object not seen, no pose that fits) does not use up the stop,
or the request: `rejected()` lets the next revolutions make another.

**After a restart** the robot may still be parked where its look was taken. `resume()` takes the newest look that the
session's history has of this robot, and a robot found at that place, or seeing that scene, has had its look of this
stop. Other processes receive the same scans: give `resume()` every look of this robot that the session gets, whoever
took it.

Nothing here knows a clock: what counts is revolutions.
"""

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.grids import BeamGrid, aligned
from voa_ros.looks import Revolution, GatheredLook, Waiting, Where, look_of
from voa_ros.messages import LaserScan
from voa_ros.motions import within
from voa_ros.robots import LookRule
from voa_ros.scans import laser_scan
from voa_ros.scenes import CLEARLY, scene_difference
from voa_ros.tracks import NoPose

AWAY_BY_POSE = 3
AWAY_BY_SCENE = 5
"""Revolutions in a row until a robot has moved on."""
PARKED = 10
"""Looks in a row from one place, in mode `every`, that show a parked robot."""

MOVE_ON = "the robot to move on: this stop's look is taken"


class LookTaker:
    """Gathers the revolutions of one robot into looks."""

    def __init__(self, robot: str, rule: LookRule, grid: BeamGrid) -> None:
        """Begin with no revolution.

        Args:
            robot: its name, which its looks carry.
            rule: when scans are a look.
            grid: beams of the scenario's lidar, for revolutions whose beams differ.
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
        """Whether a look was requested and not taken yet."""
        return self._requested

    @property
    def standing(self) -> int:
        """Revolutions of the present stop so far."""
        return len(self._stop)

    @property
    def parked(self) -> bool:
        """Whether each scan is a look while the robot does not move: the belief grows falsely certain."""
        return self._parked >= PARKED

    def request(self) -> None:
        """Ask for a look of the next revolutions for which the robot stands still.

        Raises:
            ValueError: looks are not taken on request.
        """
        if self._rule.mode != "on_request":
            raise ValueError(f"expected a robot in mode 'on_request', {self._robot!r} is in mode {self._rule.mode!r}")
        self._requested = True
        self._rejected = None
        self._stop.clear()
        self._waiting_for = "the robot to stop"

    def resume(self, request: ScanRequest) -> None:
        """Take note of a look of this robot that the session has: the newest, taken by this process or another.

        A robot that is still there has had its look of this stop. (It matters in mode `stationary` alone.) Taking note
        of one look twice changes nothing.
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
        """Let the next revolutions make another look: the last one was not accepted.

        Args:
            reason: in a few words, for `waiting_for`.
            request: the look; None: the newest. The answer may come when the robot has moved on, or has had another
                look; nothing changes then.
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
        """Take a revolution, in the order in which they come.

        Args:
            scan: the revolution.
            where: the lidar's pose in the middle of it, or the sensor configuration where it stands.
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
        """Count the looks from one place, in mode `every`."""
        still = self._taken is not None and self._stands(revolution, self._taken)
        self._parked = self._parked + 1 if still else 1
        if not still:
            self._taken = revolution

    def _moved_on(self, revolution: Revolution, taken: Revolution) -> bool:
        """Count the revolutions away from the look, and forget the look when they are enough."""
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
        """Whether a revolution is not where the look was taken, and how many such in a row are a move."""
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
        self._note(look.request)  # also where it equals the look before: without stamps and noise it may
        self._stop.clear()
        self._requested = False
        self._wait("a request" if self._rule.mode == "on_request" else MOVE_ON)
        return look

    def _progress(self) -> str:
        """How far the look of this stop is, and why the one before it does not count."""
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
