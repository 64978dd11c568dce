"""Texts of a card: session, poses, robots."""

from datetime import UTC, datetime, timedelta

import pytest

from voa_client import RobotReport, Session, SessionSummary
from voa_console.now.summary import age, robot_line, summarise
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose

NOW = datetime(2026, 11, 29, 12, 0, 0, tzinfo=UTC)


def session(belief: list[float], **more: object) -> Session:
    given = {
        "id": "s1",
        "scenario": "abc",
        "version": 3,
        "poses": [f"P{index}" for index in range(len(belief))],
        "belief": belief,
        "best_grasp": "TOP",
        "expected_score": 0.55,
        "entropy_nats": 0.1,
        "last_fit_rmsd_mm": None,
        "created_at": NOW - timedelta(minutes=12),
        "updated_at": NOW - timedelta(seconds=3),
    }
    return Session.model_validate(given | more)


def test_a_card_has_the_three_likeliest_poses_the_rest_together_and_the_grasp() -> None:
    card = summarise(session([0.05, 0.5, 0.3, 0.1, 0.05]), None, [], NOW)
    assert [(bar.name, bar.figure) for bar in card.poses] == [("P1", "0.50"), ("P2", "0.30"), ("P3", "0.10")]
    assert card.others == "2 other poses together 0.10"
    assert (card.grasp, card.score, card.title) == ("Best grasp TOP", "0.55", "abc")
    assert card.moved == "version 3, changed 3 s ago, opened 12 min ago"
    assert card.state == "Waits for a look"
    assert card.absent is None
    assert not card.is_alarming


def test_a_card_says_that_no_grasp_can_succeed_and_that_the_object_may_be_absent() -> None:
    card = summarise(session([1.0], best_grasp=None, expected_score=0.0, absent=0.4), None, [], NOW)
    assert (card.grasp, card.score) == ("No grasp can succeed", "")
    assert card.absent == "object at none of the poses: 0.40"
    assert card.others == ""


def test_a_card_says_why_its_session_is_not_followed() -> None:
    assert summarise(session([1.0]), None, [], NOW).problem == ""
    assert summarise(session([1.0]), None, [], NOW, None, "The service is busy.").problem == "The service is busy."


def test_a_session_without_belief_shows_no_poses() -> None:
    fields = session([1.0]).model_dump()
    listed = SessionSummary(**{name: fields[name] for name in SessionSummary.model_fields})
    assert summarise(listed, None, [], NOW).poses == ()


def report(**more: object) -> RobotReport:
    given = {
        "robot": "tb3_1",
        "session": "s1",
        "source": "ros2",
        "key": "tb3_1/scan",
        "last_scan_at": NOW - timedelta(seconds=0.3),
        "scans": 100,
        "looks": 1,
        "refused": 0,
        "last_refusal": None,
        "waiting_for": None,
    }
    return RobotReport.model_validate(given | more)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        (
            {"sensor": "ENE", "gathered": 7, "wanted": 10, "waiting_for": "standing still: 7 of 10 revolutions"},
            "tb3_1 standing at ENE, scan 0.3 s ago, 7 of 10 revolutions",
        ),
        ({"waiting_for": "the robot to stop"}, "tb3_1 driving, scan 0.3 s ago"),
        (
            {
                "waiting_for": "the robot to stop",
                "sensor_pose": UncertainSensorPose(x=0.36, y=-0.17, yaw_rad=0.0, std=PoseUncertainty(xy_m=0.01)),
            },
            "tb3_1 driving, now at x 0.36 m, y -0.17 m, scan 0.3 s ago",
        ),
        ({"waiting_for": "a request", "sensor": "N"}, "tb3_1 at N, scan 0.3 s ago, waiting for a request"),
        ({"last_scan_at": None, "waiting_for": "a scan"}, "tb3_1, no scan yet, waiting for a scan"),
        ({"source": "scan"}, "tb3_1, scan 0.3 s ago"),
    ],
)
def test_a_robot_s_sentence(fields: dict[str, object], text: str) -> None:
    assert robot_line(report(**fields), None, NOW).text == text


def test_a_refusal_alarms() -> None:
    line = robot_line(report(), "the lidar's frame is missing", NOW)
    assert summarise(session([1.0]), None, [line], NOW).is_alarming


@pytest.mark.parametrize(
    ("seconds", "text"), [(-1, "0.0 s"), (0.34, "0.3 s"), (59, "59 s"), (300, "5 min"), (9000, "2 h")]
)
def test_an_age(seconds: float, text: str) -> None:
    assert age(timedelta(seconds=seconds)) == text
