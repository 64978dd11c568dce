"""Robots as the service reports them: do their scans count, and if not, why and what to do."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from voa_cli.doctor.findings import Finding, State
from voa_cli.doctor.remedies import for_refusal, for_rejection, for_waiting, for_warning, is_blocked
from voa_msgs.robots import LookReport, RobotReport, Robots

_QUIET_S = 5.0
"""A lidar turns five times a second."""
_KIND = re.compile(r"[a-z]+(-[a-z]+)*")
_USABLE = "a scan that can be used"
_BY_REFUSAL = (_USABLE, "scans of one frame")
"""Conditions that say less than the newest refusal does."""
_RESTLESS = 100
"""Scans without any look after which a robot that is said to drive may be one that seems to."""


@dataclass(frozen=True)
class _Trouble:
    """Something that is wrong with a robot.

    Attributes:
        state: how much it matters.
        why: in words; "" where what the robot waits for says it.
        advice: what to do.
    """

    state: State
    why: str
    advice: str


def needs_second_report(robots: Robots) -> bool:
    """Whether a second report would tell what is wrong now from what was wrong once."""
    return any(robot.refused or is_blocked(robot.waiting_for) for robot in robots.items)


def check_robots(robots: Robots, now: datetime, before: Robots | None = None) -> Iterator[Finding]:
    """Judge every robot, and the mapping that is in force.

    Args:
        robots: as reported.
        now: when, by the service's clock.
        before: as reported a moment earlier; None: nothing is known of what happens at the moment, and everything that
            was refused counts.
    """
    if robots.mapping_error is not None:
        advice = "correct the file; until then the mapping before it is in force"
        yield Finding("mapping", "wrong", robots.mapping_error, advice)
    if not robots.items:
        advice = "put scans on scan/<session>/<robot>, or map topics: voa serve --robots"
        yield Finding("robots", "warning", "the service has received scans of none, and none is mapped", advice)
    earlier = {} if before is None else {(robot.robot, robot.source): robot for robot in before.items}
    for robot in robots.items:
        yield _robot(robot, earlier.get((robot.robot, robot.source)), now)
        for kind, detail in {warning.kind: warning.detail for warning in robot.warnings}.items():
            yield Finding(f"robot {robot.robot}: {kind}", "warning", detail, for_warning(kind))


def _robot(robot: RobotReport, before: RobotReport | None, now: datetime) -> Finding:
    check = f"robot {robot.robot}"
    if robot.last_scan_at is None:
        seen = f"no scan yet on {robot.key}"
        return Finding(check, "wrong", seen, "is its lidar on, its bridge joined? --robots FILE looks at its topics")
    ago = max(0.0, (now - robot.last_scan_at).total_seconds())
    trouble = (
        _without_session(robot)
        or _blocked(robot, before)
        or _rejected(robot, now)
        or _refused(robot, before)
        or _silent(ago)
        or _restless(robot)
        or _Trouble("ok", "", "")
    )
    received = [_counts(robot), f"last scan {ago:.1f} s ago"]
    waits = [] if trouble.why and robot.waiting_for in _BY_REFUSAL else _waits(robot)
    parts = [*received, *waits] if trouble.state == "ok" else [trouble.why, *waits, *received]
    return Finding(check, trouble.state, "; ".join(filter(None, parts)), trouble.advice)


def _waits(robot: RobotReport) -> list[str]:
    """Condition for the next look, without what the newest look says by itself."""
    condition, _, _ = (robot.waiting_for or "").partition("; the last look was not accepted")
    return [f"waits for {condition}"] if condition else []


def _told(refusal: str | None) -> str:
    """Why a scan was refused, without the name of the kind of problem."""
    kind, separator, detail = (refusal or "").partition(": ")
    return detail if separator and _KIND.fullmatch(kind) else refusal or ""


def _counts(robot: RobotReport) -> str:
    scans, looks = _counted(robot.scans, "scan"), _counted(robot.looks, "look")
    return f"{scans}, {looks}, {robot.refused} refused"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _accepted(robot: RobotReport) -> bool:
    return robot.last_look is not None and robot.last_look.accepted


def _without_session(robot: RobotReport) -> _Trouble | None:
    if robot.session is not None or is_blocked(robot.waiting_for):
        return None
    advice = f"open a session, or claim the robot for one: PUT /v1/robots/{robot.robot}/session"
    return _Trouble("wrong", "there is no session for it", advice)


def _blocked(robot: RobotReport, before: RobotReport | None) -> _Trouble | None:
    """Find that no look can come until something is done."""
    if robot.waiting_for is None or not is_blocked(robot.waiting_for):
        return None
    if robot.waiting_for == _USABLE and not robot.refused:  # a scan is being read at this moment
        return None
    passing = _accepted(robot) and before is not None and not is_blocked(before.waiting_for)
    advice = for_waiting(robot.waiting_for, robot.last_refusal)
    why = _told(robot.last_refusal) if robot.waiting_for in _BY_REFUSAL else ""
    return _Trouble("warning" if passing else "wrong", why, advice)


def _rejected(robot: RobotReport, now: datetime) -> _Trouble | None:
    """Find that the newest look was not accepted; of many raw scans, some may not be."""
    look = robot.last_look
    if look is None or look.accepted:
        return None
    ago = max(0.0, (now - look.at).total_seconds())
    newest = _told(robot.last_refusal)
    told = newest if (look.reason or "") in newest else look.reason
    why = f"the newest look, {ago:.0f} s ago {_where(look)}, was not accepted: {told}"
    some = robot.source == "scan" and robot.looks > robot.refused
    return _Trouble("warning" if some else "wrong", why, for_rejection(look.reason))


def _where(look: LookReport) -> str:
    if look.sensor_pose is None:
        return f"at sensor {look.sensor!r}"
    pose = look.sensor_pose
    return f"at x {pose.x:.2f} m, y {pose.y:.2f} m, yaw {math.degrees(pose.yaw_rad):.0f} degrees"


def _refused(robot: RobotReport, before: RobotReport | None) -> _Trouble | None:
    """Find that nothing of it counts, or that some of its scans do not at the moment."""
    if not robot.refused:
        return None
    advice = for_refusal(robot.last_refusal or "")
    if not robot.looks:
        return _Trouble("wrong", f"nothing of it counts: {_told(robot.last_refusal)}", advice)
    if before is not None and robot.refused == before.refused:
        return None
    return _Trouble("warning", f"some do not count, the newest: {_told(robot.last_refusal)}", advice)


def _silent(ago_s: float) -> _Trouble | None:
    return _Trouble("warning", "", "it has gone silent: is it on, in the network?") if ago_s > _QUIET_S else None


def _restless(robot: RobotReport) -> _Trouble | None:
    """Find a robot that never seems to stand still."""
    if robot.looks or robot.scans < _RESTLESS or not (robot.waiting_for or "").startswith("the robot to stop"):
        return None
    advice = "if it is parked: does its odometry drift (still_xy_m, still_yaw_rad), do people walk about in its view?"
    return _Trouble("warning", "", advice)
