"""Sentences about a robot: its pose with its uncertainty, and its last refusals."""

from datetime import UTC, datetime, timedelta
from typing import Any

from voa_client import RobotReport
from voa_console.robots.doing import RefusalLine, certainty, doing, refusal_lines
from voa_msgs.geometry import PoseUncertainty, UncertainSensorPose
from voa_msgs.robots import Refusal

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
POSE = UncertainSensorPose(x=0.3, y=-0.01, yaw_rad=1.5707963267948966)


def report(**fields: Any) -> RobotReport:
    known: dict[str, Any] = {"robot": "tb3_1", "session": "S", "source": "ros2", "key": "tb3_1/scan", "scans": 9}
    known |= {"looks": 0, "refused": 0, "last_refusal": None, "waiting_for": None, "last_scan_at": NOON}
    return RobotReport(**(known | fields))


def test_a_robot_that_gathers_a_look() -> None:
    gathering = report(sensor="ENE", gathered=7, wanted=10, waiting_for="standing still: 7 of 10 revolutions")
    now = NOON + timedelta(seconds=0.3)
    assert doing(gathering, now) == "tb3_1 standing at ENE, scan 0.3 s ago, 7 of 10 revolutions"


def test_the_pose_is_written_with_its_uncertainty() -> None:
    assert certainty(report()) == ""
    assert certainty(report(sensor_pose=POSE)) == "Lidar at x 0.300 m, y -0.010 m, yaw 90.0°, taken as exact."
    known = POSE.model_copy(update={"std": PoseUncertainty(xy_m=0.012, yaw_rad=0.02)})
    assert certainty(report(sensor_pose=known)) == "Lidar at x 0.300 m, y -0.010 m (± 1.2 cm), yaw 90.0° (± 1.1°)."


def test_refusals_have_their_age_and_number() -> None:
    refusals = [Refusal(at=NOON, reason="new", times=3), Refusal(at=NOON - timedelta(minutes=5), reason="old")]
    lines = refusal_lines(report(refusals=refusals), NOON + timedelta(seconds=1))
    assert lines == (RefusalLine("1.0 s ago, 3 times", "new"), RefusalLine("5 min ago", "old"))
