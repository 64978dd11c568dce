"""Sentences about a robot: what it is doing, how well its pose is known, and its last refusals."""

import math
from dataclasses import dataclass
from datetime import datetime

from voa_client import RobotReport
from voa_console.now.summary import age, robot_line


@dataclass(frozen=True)
class RefusalLine:
    """Refusal of scans in words: its age and number, and the reason."""

    when: str
    reason: str


def doing(report: RobotReport, now: datetime) -> str:
    """Write what a robot is doing, as in "tb3_1 standing at ENE, scan 0.3 s ago, 7 of 10 revolutions".

    Args:
        report: on the robot.
        now: time by the clock of the service.
    """
    return robot_line(report, None, now).text


def certainty(report: RobotReport) -> str:
    """Write the measured pose of a robot's lidar with its standard deviations; "" if it is not measured."""
    pose = report.sensor_pose
    if pose is None:
        return ""
    yaw = math.degrees(pose.yaw_rad)
    if pose.std is None:
        return f"Lidar at x {pose.x:.3f} m, y {pose.y:.3f} m, yaw {yaw:.1f}°, taken as exact."
    xy, turn = 100.0 * pose.std.xy_m, math.degrees(pose.std.yaw_rad)
    return f"Lidar at x {pose.x:.3f} m, y {pose.y:.3f} m (± {xy:.1f} cm), yaw {yaw:.1f}° (± {turn:.1f}°)."


def refusal_lines(report: RobotReport, now: datetime) -> tuple[RefusalLine, ...]:
    """Write the newest refusals of a robot, the newest first.

    Args:
        report: on the robot.
        now: time by the clock of the service.
    """
    return tuple(
        RefusalLine(
            f"{age(now - refusal.at)} ago{'' if refusal.times == 1 else f', {refusal.times} times'}", refusal.reason
        )
        for refusal in report.refusals
    )
