"""Checks of robots, as the service reports them: do their scans make looks, and if not, why not."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from voa_doctor.findings import Finding, State
from voa_doctor.remedies import for_refusal, for_rejection, for_waiting, for_warning, is_blocked
from voa_msgs.robots import LookReport, RobotReport, Robots

_QUIET_S = 5.0
"""Time without scans after which a robot counts as silent, seconds; lidars send five scans per second."""
_KIND = re.compile(r"[a-z]+(-[a-z]+)*")
_USABLE = "a scan that can be used"
_BY_REFUSAL = (_USABLE, "scans of one frame")
"""Conditions for which the newest refusal has the details."""
_RESTLESS = 100
"""Number of scans without a look after which a robot that seems to drive may have drifting odometry."""


@dataclass(frozen=True)
class _Trouble:
    """A reason why a robot's scans make no looks.

    Attributes:
        state: of the finding.
        why: the reason; "" if the condition for the next look says it.
        advice: action that a person should take.
    """

    state: State
    why: str
    advice: str


def needs_second_report(robots: Robots) -> bool:
    """True if a second report is needed to see whether past problems still exist."""
    return any(robot.refused or is_blocked(robot.waiting_for) for robot in robots.items)


def check_robots(robots: Robots, now: datetime, before: Robots | None = None) -> Iterator[Finding]:
    """Check every robot, and the mapping.

    Args:
        robots: the service's report.
        now: time of the report, by the service's clock.
        before: report of a moment earlier; None: there is none, and all past refusals count.
    """
    if robots.mapping_error is not None:
        advice = "correct the file; until then the service uses the previous mapping"
        yield Finding("mapping", "wrong", robots.mapping_error, advice)
    if not robots.items:
        advice = "publish scans on scan/<session>/<robot>, or map topics by `voa serve --robots FILE`"
        yield Finding("robots", "warning", "no robot sends scans over Zenoh, and none is mapped", advice)
    earlier = {} if before is None else {(robot.robot, robot.source): robot for robot in before.items}
    for robot in robots.items:
        yield _robot(robot, earlier.get((robot.robot, robot.source)), now)
        for kind, detail in {warning.kind: warning.detail for warning in robot.warnings}.items():
            yield Finding(f"robot {robot.robot}: {kind}", "warning", detail, for_warning(kind))


def _robot(robot: RobotReport, before: RobotReport | None, now: datetime) -> Finding:
    check = f"robot {robot.robot}"
    if robot.last_scan_at is None:
        refused = _refused(robot, before)
        if refused is not None:
            return Finding(check, refused.state, f"{refused.why}; {_counts(robot)}", refused.advice)
        seen = f"no scan yet on {robot.key}"
        return Finding(
            check,
            "wrong",
            seen,
            "check that its lidar is on, and its bridge connected; --robots FILE checks its topics",
        )
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
    """Return the condition for the next look, without the remark that the newest look was not accepted."""
    condition, _, _ = (robot.waiting_for or "").partition("; the last look was not accepted")
    return [f"waits for {condition}"] if condition else []


def _without_kind(refusal: str | None) -> str:
    """Return the reason of a refusal without the kind of the problem before it."""
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
    return _Trouble("wrong", "no session receives its scans", advice)


def _blocked(robot: RobotReport, before: RobotReport | None) -> _Trouble | None:
    """Find a condition that is not met until a person does something."""
    if robot.waiting_for is None or not is_blocked(robot.waiting_for):
        return None
    if robot.waiting_for == _USABLE and not robot.refused:  # a scan is being read at this moment
        return None
    passing = _accepted(robot) and before is not None and not is_blocked(before.waiting_for)
    advice = for_waiting(robot.waiting_for, robot.last_refusal)
    why = _without_kind(robot.last_refusal) if robot.waiting_for in _BY_REFUSAL else ""
    return _Trouble("warning" if passing else "wrong", why, advice)


def _rejected(robot: RobotReport, now: datetime) -> _Trouble | None:
    """Find that the newest look was not accepted; a warning only, if others of a robot that sends raw scans were."""
    look = robot.last_look
    if look is None or look.accepted:
        return None
    ago = max(0.0, (now - look.at).total_seconds())
    newest = _without_kind(robot.last_refusal)
    reason = newest if (look.reason or "") in newest else look.reason
    why = f"the newest look, {ago:.0f} s ago {_where(look)}, was not accepted: {reason}"
    some = robot.source == "scan" and robot.looks > robot.refused
    return _Trouble("warning" if some else "wrong", why, for_rejection(look.reason))


def _where(look: LookReport) -> str:
    if look.sensor_pose is None:
        return f"at sensor {look.sensor!r}"
    pose = look.sensor_pose
    return f"at x {pose.x:.2f} m, y {pose.y:.2f} m, yaw {math.degrees(pose.yaw_rad):.0f} degrees"


def _refused(robot: RobotReport, before: RobotReport | None) -> _Trouble | None:
    """Find that all scans of a robot are refused, or some at the moment."""
    if not robot.refused:
        return None
    advice = for_refusal(robot.last_refusal or "")
    if not robot.looks:
        return _Trouble("wrong", f"all its scans are refused: {_without_kind(robot.last_refusal)}", advice)
    if before is not None and robot.refused == before.refused:
        return None
    return _Trouble("warning", f"some scans are refused, the newest: {_without_kind(robot.last_refusal)}", advice)


def _silent(ago_s: float) -> _Trouble | None:
    return (
        _Trouble("warning", "", "it sends no scans any more: check that it is on, and in the network")
        if ago_s > _QUIET_S
        else None
    )


def _restless(robot: RobotReport) -> _Trouble | None:
    """Find a robot that seems to move all the time."""
    if robot.looks or robot.scans < _RESTLESS or not (robot.waiting_for or "").startswith("the robot to stop"):
        return None
    advice = (
        "if it is parked: check if its odometry drifts (still_xy_m, still_yaw_rad), or people walk through its view"
    )
    return _Trouble("warning", "", advice)
