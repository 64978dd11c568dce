"""What the service has heard of robots."""

from collections.abc import Iterator
from datetime import datetime

from voa_cli.doctor.findings import Finding
from voa_msgs.robots import RobotReport, Robots

_QUIET_S = 5.0
"""A lidar turns five times a second."""


def check_robots(robots: Robots, now: datetime) -> Iterator[Finding]:
    """One finding per robot; `now` by the service's clock."""
    if not robots.items:
        advice = "put scans on scan/<session>/<robot>, or map topics: voa serve --robots"
        yield Finding("robots", "warning", "the service has heard of none, and none is mapped", advice)
    for robot in robots.items:
        yield _robot(robot, now)


def _robot(robot: RobotReport, now: datetime) -> Finding:
    check = f"robot {robot.robot}"
    if robot.last_scan_at is None:
        seen = f"no scan yet on {robot.key}"
        return Finding(check, "wrong", seen, "is its lidar on, its bridge joined? --robots FILE listens itself")
    ago = (now - robot.last_scan_at).total_seconds()
    seen = f"{robot.scans} scans, {robot.looks} looks, {robot.refused} refused; last scan {max(0.0, ago):.1f} s ago"
    if robot.waiting_for is not None:
        seen += f"; waits for {robot.waiting_for}"
    if robot.refused and not robot.looks:
        return Finding(
            check, "wrong", f"{seen}; {robot.last_refusal}", "nothing of it counts: the newest reason says why"
        )
    if robot.session is None:
        return Finding(
            check, "wrong", f"{seen}; there is no session for it", "open a session, or name one in the mapping"
        )
    if ago > _QUIET_S:
        return Finding(check, "warning", seen, "it has gone silent: is it on, in the network?")
    if robot.refused:
        return Finding(
            check, "warning", f"{seen}; newest reason: {robot.last_refusal}", "some of its scans do not count"
        )
    return Finding(check, "ok", seen)
