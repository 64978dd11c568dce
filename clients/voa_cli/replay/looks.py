"""The looks of a replayed recording, as a JSON document and as a table."""

from datetime import UTC, datetime
from math import degrees
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from voa_cli.replay.sessions import show_damage
from voa_client.formatting import share
from voa_recordings.replay.looks import LooksReport, ReplayedLook, ReplayedRobot


def document(report: LooksReport) -> dict[str, Any]:
    """Return the document of `voa replay --json`."""
    return {
        "messages": report.messages,
        "damage": report.damage,
        "scenario": report.scenario.id,
        "robots": [_robot(robot) for robot in report.robots],
        "looks": [_look(look) for look in report.looks],
    }


def _robot(robot: ReplayedRobot) -> dict[str, Any]:
    return {
        "robot": robot.robot,
        "session": robot.session,
        "scans": robot.scans,
        "looks": robot.looks,
        "waiting_for": robot.waiting_for,
        "warnings": [warning.model_dump(mode="json", exclude_none=True) for warning in robot.warnings],
        "unreadable": robot.unreadable,
    }


def _look(look: ReplayedLook) -> dict[str, Any]:
    request = look.request.model_dump(mode="json", exclude_none=True)
    response = look.response
    return {
        "robot": look.robot,
        "stamp": look.request.scan.stamp,
        "sensor": request.get("sensor"),
        "sensor_pose": request.get("sensor_pose"),
        "refused": look.refused,
        "update": None if response is None else response.update.model_dump(mode="json"),
        "version": None if response is None else response.version,
        "belief": None if response is None else response.belief,
        "best_grasp": None if response is None else response.best_grasp,
        "expected_score": None if response is None else response.expected_score,
    }


def show(console: Console, report: LooksReport) -> None:
    """Print a row per look, then a sentence per robot with its warnings, and the damage of the recording."""
    several = len(report.robots) > 1
    headings = ["time", *(["robot"] if several else []), "where", "result", "best grasp", "score"]
    table = Table(*headings, title="Looks", title_justify="left")
    for look in report.looks:
        robot = [escape(look.robot)] if several else []
        table.add_row(_time(look), *robot, escape(lidar_place(look)), *_outcome(look))
    console.print(table if report.looks else "no look")
    for each in report.robots:
        waits = "" if each.waiting_for is None else f"; at the end it waits for {each.waiting_for}"
        summary = f"{each.robot}: {each.scans} scans, {each.looks} looks{waits}; session {each.session}"
        console.print(summary, highlight=False, markup=False)
        for warning in each.warnings:
            console.print(f"! {warning.kind}: {warning.detail}", highlight=False, markup=False)
        if each.unreadable is not None:
            console.print(f"! {each.unreadable}", highlight=False, markup=False)
    show_damage(console, report.damage, report.messages)


def lidar_place(look: ReplayedLook) -> str:
    """Return the place of the lidar in a few words: a sensor's name, or x and y in metres and yaw in degrees."""
    pose = look.request.sensor_pose
    if pose is None:
        return str(look.request.sensor)
    return f"x {pose.x:.3f} y {pose.y:.3f} yaw {degrees(pose.yaw_rad):.1f}°"


def _time(look: ReplayedLook) -> str:
    """Return the time of the look's last revolution by the robot's clock; "" if it has none."""
    stamp = look.request.scan.stamp
    last = stamp.get("to") if isinstance(stamp, dict) else None
    seconds, parts = (last.get("sec"), last.get("nanosec")) if isinstance(last, dict) else (None, None)
    if not isinstance(seconds, int) or not isinstance(parts, int):
        return ""
    return f"{datetime.fromtimestamp(seconds, UTC):%m-%d %H:%M:%S}.{parts // 10_000_000:02}"


def _outcome(look: ReplayedLook) -> tuple[str, str, str]:
    if look.response is None:
        return escape(f"refused: {look.refused}"), "", ""
    update = look.response.update
    result = ("accepted" if update.accepted else "not accepted") + (f": {update.reason}" if update.reason else "")
    return result, escape(look.response.best_grasp or "none"), share(look.response.expected_score, 3)
