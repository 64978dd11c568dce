"""Reports of robots, in words: what keeps their scans from counting while it does, and what to do about it."""

from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from tests.voa_ros.parking import ParkingRobot, mapped, play
from voa_doctor.findings import Finding
from voa_doctor.robots import check_robots, needs_second_report
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.robots import LookReport, RobotReport, Robots
from voa_msgs.warnings import ProbableMistake, WarningKind
from voa_ros.cdr import decode_laser_scan, encode_laser_scan
from voa_ros.pipeline import LookPipeline, Received
from voa_ros.topics import LASER_SCAN

NOW = datetime(2026, 1, 1, tzinfo=UTC)
LOOK = LookReport(
    at=NOW - timedelta(seconds=3), sensor="E", sensor_pose=None, accepted=True, reason=None, version=1
)  # fmt: skip
WELL = RobotReport(
    robot="r1", session="s1", source="ros2", key="r1/scan", last_scan_at=NOW - timedelta(seconds=0.1), scans=9, looks=1,
    refused=0, last_refusal=None, waiting_for="the robot to move on: this stop's look is taken", last_look=LOOK,
)  # fmt: skip


def finding_of(changes: dict[str, Any], before: dict[str, Any] | None = None) -> Finding:
    report = WELL.model_copy(update=changes)
    earlier = None if before is None else Robots(items=[report.model_copy(update=before)])
    (result,) = check_robots(Robots(items=[report]), NOW, earlier)
    assert (result.advice == "") == (result.state == "ok")
    return result


def rejected(reason: str, **changes: Any) -> dict[str, Any]:
    """A robot whose newest look was not accepted."""
    refusal = f"not-accepted: the belief is unchanged, {reason}: in words"
    look = LOOK.model_copy(update={"accepted": False, "reason": reason})
    return {"refused": 1, "last_refusal": refusal, "last_look": look} | changes


FRESH = {"looks": 0, "last_look": None, "waiting_for": "the robot to stop"}
"""A robot that has had no look yet."""
POSE = UncertainSensorPose(x=0.4, y=-0.12, yaw_rad=3.14159)


@pytest.mark.parametrize(
    ("changes", "state", "seen", "advice"),
    [
        ({}, "ok", "9 scans, 1 look, 0 refused; last scan 0.1 s ago; waits for the robot to move on", ""),
        (FRESH, "ok", "0 looks, 0 refused; last scan 0.1 s ago; waits for the robot to stop", ""),
        (FRESH | {"scans": 500}, "warning", "500 scans, 0 looks", "if it is parked: check if its odometry drifts"),
        ({"last_scan_at": None, "scans": 0}, "wrong", "no scan yet on r1/scan", "check that its lidar is on"),
        (
            FRESH | {"session": None, "last_scan_at": None, "scans": 0, "refused": 2, "last_refusal": "bad"},
            "wrong", "all its scans are refused: bad; 0 scans, 0 looks, 2 refused", "follow the reason",
        ),
        ({"last_scan_at": NOW - timedelta(minutes=1)}, "warning", "60.0 s ago", "it sends no scans any more"),
        ({"session": None}, "wrong", "no session receives its scans", "PUT /v1/robots/r1/session"),
        (FRESH | {"refused": 9, "last_refusal": "bad"}, "wrong", "all its scans are refused: bad", "follow the reason"),
        ({"refused": 1, "last_refusal": "bad"}, "warning", "some scans are refused, the newest: bad", "the reason"),
        (rejected("no_beams"), "wrong", "the newest look, 3 s ago at sensor 'E', was not accepted: the bel", "turn"),
        (rejected("nothing_seen"), "wrong", "nothing_seen: in words", "the object lies in the workspace"),
        (rejected("bad_fit"), "wrong", "bad_fit: in words", "the scenario's object"),
        (rejected("no_match"), "wrong", "no_match: in words", "origin, lidar, upside_down"),
        (rejected("bad_fit", last_refusal="bad"), "wrong", "was not accepted: bad_fit", "the scenario's object"),
        (rejected("no_match", source="scan", looks=5), "warning", "5 looks, 1 refused", "the scenario's object"),
        (
            {"last_look": LOOK.model_copy(update={"accepted": False, "sensor": None, "sensor_pose": POSE})},
            "wrong", "at x 0.40 m, y -0.12 m, yaw 180 degrees, was not accepted", "follow the reason",
        ),
    ],
)  # fmt: skip
def test_reports_of_robots(changes: dict[str, Any], state: str, seen: str, advice: str) -> None:
    result = finding_of(changes)
    assert (result.state, seen in result.seen, advice in result.advice) == (state, True, True), result


def test_past_refusals_differ_from_present_ones() -> None:
    once = {"refused": 5, "last_refusal": "expected something else"}
    assert needs_second_report(Robots(items=[WELL.model_copy(update=once)]))
    assert not needs_second_report(Robots(items=[WELL]))
    now, then = finding_of(once, {"refused": 3}), finding_of(once, {"refused": 5})
    assert (now.state, then.state) == ("warning", "ok")
    assert "5 refused" in then.seen


def test_a_condition_that_comes_and_goes_is_a_warning() -> None:
    gone = {"waiting_for": "the lidar's pose: the newest odometry is 0.3 s old", "refused": 2, "last_refusal": "old"}
    passing = finding_of(gone, {"waiting_for": "the robot to stop"})
    assert (passing.state, finding_of(gone, {}).state, finding_of(gone).state) == ("warning", "wrong", "wrong")


def test_a_scan_that_is_just_being_read_is_not_wrong() -> None:
    assert finding_of({"waiting_for": "a scan that can be used"}).state == "ok"


def changed(**changes: Any) -> list[Received]:
    """Messages of a robot whose scans are others than they should be."""

    def spoiled(number: int, message: Received) -> Received:
        if message.type != LASER_SCAN:
            return message
        scan = decode_laser_scan(message.payload)
        figures = {name: value(number) if callable(value) else value for name, value in changes.items()}
        return replace(message, payload=encode_laser_scan(replace(scan, **figures)))

    return [spoiled(number, message) for number, message in enumerate(ParkingRobot().messages())][:60]


def scans_alone(messages: Iterable[Received]) -> list[Received]:
    return [message for message in messages if message.type == LASER_SCAN][:20]


def repeated() -> list[Received]:
    first, *_ = scans_alone(ParkingRobot().messages())
    return [first] * 20


def in_turn(*names: str) -> Any:
    return lambda number: names[number % len(names)]


def as_reported(looks: LookPipeline, messages: list[Received]) -> RobotReport:
    """Report of the service on a robot after these messages."""
    came = play(looks, messages)
    count = sum(message.type == LASER_SCAN for message in messages)
    return WELL.model_copy(
        update={
            "scans": count,
            "looks": len(came.looks),
            "last_look": None,
            "refused": len(came.refused),
            "last_refusal": came.refused[-1] if came.refused else None,
            "waiting_for": looks.waiting_for,
            "warnings": looks.warnings,
        }
    )


@pytest.mark.parametrize(
    ("looks", "messages", "seen", "advice"),
    [
        (mapped(), changed(angle_increment=-0.05), "say that the angles grow", "correct the driver's settings"),
        (mapped(), changed(angle_increment=1.0, angle_max=119.0), "are 19.1 turns", "correct the driver's settings"),
        (
            mapped(most_beams=100),
            changed(),
            "expected at most 100 values, got 120",
            "set that variable for `voa serve`",
        ),
        (mapped(), changed(frame_id=in_turn("a", "b")), "scans of 2 frames on one topic ('a', 'b')", "frame_id ="),
        (mapped(more='frame_id = "front"'), changed(), "waits for a scan of frame 'front'", "correct frame_id"),
        (mapped(), repeated(), "waits for a scan that was not received before", "restart the driver"),
        (
            mapped(),
            scans_alone(ParkingRobot().messages()),
            "no odometry was received yet",
            "check that its topic is published",
        ),
        (mapped('from = "amcl"'), changed(), "no AMCL pose was received yet", "give AMCL its initial pose"),
    ],
    ids=["mirrored", "degrees", "beams", "frames", "frame", "repeated", "odometry", "AMCL"],
)
def test_conditions_that_are_not_met_while_something_is_wrong(
    looks: LookPipeline, messages: list[Received], seen: str, advice: str
) -> None:
    (result,) = check_robots(Robots(items=[as_reported(looks, messages)]), NOW)
    assert (result.state, seen in result.seen, advice in result.advice) == ("wrong", True, True), result


def test_a_parked_robot_whose_every_scan_is_a_look_is_warned_of() -> None:
    report = as_reported(mapped(look='mode = "every"'), changed())
    result = list(check_robots(Robots(items=[report]), NOW))
    assert [finding.check for finding in result] == ["robot r1", "robot r1: every-while-parked"]
    assert result[1].state == "warning"
    assert "the belief becomes falsely certain" in result[1].seen
    assert "stationary" in result[1].advice


def test_each_warning_has_a_line_with_what_to_do() -> None:
    kinds: tuple[WarningKind, ...] = ("poor-fit", "scan-mirrored", "twin-poses")
    warnings = [ProbableMistake(kind=kind, detail=f"about {kind}") for kind in (*kinds, "poor-fit")]
    report = WELL.model_copy(update={"warnings": warnings})
    first, *others = check_robots(Robots(items=[report]), NOW)
    assert first.state == "ok"
    assert [finding.seen for finding in others] == [f"about {kind}" for kind in kinds]
    assert "upside_down" in others[1].advice
    assert all(finding.advice for finding in others)


def test_a_mapping_that_could_not_be_read_is_wrong() -> None:
    result, *_ = check_robots(Robots(items=[WELL], mapping_error="robots.toml: expected TOML"), NOW)
    assert (result.check, result.state, result.seen) == ("mapping", "wrong", "robots.toml: expected TOML")


def test_no_robots_is_worth_a_warning() -> None:
    [finding] = check_robots(Robots(items=[]), NOW)
    assert finding.state == "warning"
