"""What came of the looks of a recording, as a document and as a table."""

from datetime import UTC, datetime
from math import degrees
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from voa_client.formatting import share
from voa_recordings.files.reading import Recording
from voa_recordings.replay.looks import Found, Look, Replayed
from voa_recordings.replay.recordings import show_damage


def report(found: Found, recording: Recording) -> dict[str, Any]:
    """The document of `--json`."""
    return {
        "messages": recording.recovered,
        "damage": recording.damage,
        "scenario": found.scenario.id,
        "robots": [_robot(robot, found.looks) for robot in found.robots],
        "looks": [_look(look) for look in found.looks],
    }


def _robot(robot: Replayed, looks: list[Look]) -> dict[str, Any]:
    name = robot.mapping.name
    return {
        "robot": name,
        "session": robot.session,
        "scans": robot.scans,
        "looks": sum(look.robot == name for look in looks),
        "waiting_for": robot.waiting_for,
        "warnings": [warning.model_dump(mode="json", exclude_none=True) for warning in robot.warnings],
        "unreadable": robot.unreadable,
    }


def _look(look: Look) -> dict[str, Any]:
    told = look.request.model_dump(mode="json", exclude_none=True)
    answer = look.answer
    return {
        "robot": look.robot,
        "stamp": look.request.scan.stamp,
        "sensor": told.get("sensor"),
        "sensor_pose": told.get("sensor_pose"),
        "refused": look.refused,
        "update": None if answer is None else answer.update.model_dump(mode="json"),
        "version": None if answer is None else answer.version,
        "belief": None if answer is None else answer.belief,
        "best_grasp": None if answer is None else answer.best_grasp,
        "expected_score": None if answer is None else answer.expected_score,
    }


def show(console: Console, found: Found, recording: Recording) -> None:
    """A row per look, and what is wrong."""
    several = len(found.robots) > 1
    headings = ["time", *(["robot"] if several else []), "where", "result", "best grasp", "score"]
    table = Table(*headings, title="Looks", title_justify="left")
    for look in found.looks:
        table.add_row(_time(look), *([escape(look.robot)] if several else []), escape(where(look)), *_outcome(look))
    console.print(table if found.looks else "no look")
    for robot in found.robots:
        waits = "" if robot.waiting_for is None else f"; at the end it waits for {robot.waiting_for}"
        count = sum(look.robot == robot.mapping.name for look in found.looks)
        told = f"{robot.mapping.name}: {robot.scans} scans, {count} looks{waits}; session {robot.session}"
        console.print(told, highlight=False, markup=False)
        for warning in robot.warnings:
            console.print(f"! {warning.kind}: {warning.detail}", highlight=False, markup=False)
        if robot.unreadable is not None:
            console.print(f"! {robot.unreadable}", highlight=False, markup=False)
    show_damage(console, recording)


def where(look: Look) -> str:
    """Where the lidar was, short."""
    pose = look.request.sensor_pose
    if pose is None:
        return str(look.request.sensor)
    return f"x {pose.x:.3f} y {pose.y:.3f} yaw {degrees(pose.yaw_rad):.1f}°"


def _time(look: Look) -> str:
    """Of its last revolution, by the robot's clock."""
    stamp = look.request.scan.stamp
    last = stamp.get("to") if isinstance(stamp, dict) else None
    seconds, parts = (last.get("sec"), last.get("nanosec")) if isinstance(last, dict) else (None, None)
    if not isinstance(seconds, int) or not isinstance(parts, int):
        return ""
    return f"{datetime.fromtimestamp(seconds, UTC):%m-%d %H:%M:%S}.{parts // 10_000_000:02}"


def _outcome(look: Look) -> tuple[str, str, str]:
    if look.answer is None:
        return escape(f"refused: {look.refused}"), "", ""
    update = look.answer.update
    result = ("accepted" if update.accepted else "not accepted") + (f": {update.reason}" if update.reason else "")
    return result, escape(look.answer.best_grasp or "none"), share(look.answer.expected_score, 3)
