"""Looks are assigned to poses and places; what cannot be used says why."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.serving import LIDAR, SCORES
from tests.support.standing_robots import CORNER, Standing, bench_of, messages, prism, write
from tests.voa_recordings.files.bags import STEP_NS
from voa_client import VoaClientError
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan, ScanRequest
from voa_recordings.experiment_of_looks import TimedLook, experiment_scans, looks_of, times_of
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.pose_table import PoseRow
from voa_ros.motions import Motion
from voa_ros.robots import load

SCENARIO = Scenario.model_validate(
    {
        "id": "s",
        "created_at": datetime(2026, 1, 1, tzinfo=UTC),
        "name": "tiny",
        "poses": [{"name": name} for name in ("P1", "P2", "P3")],
        "grasps": [{"name": "G1"}, {"name": "G2"}],
        "scores": {"probabilities": SCORES},
        "sensors": [
            {"name": "Q1", "x": 0.0, "y": 0.0, "yaw_rad": 0.0},
            {"name": "Q2", "x": 1.0, "y": 0.0, "yaw_rad": 3.0},
        ],
        "lidar": LIDAR,
    }
)


ROBOT = """
[[robot]]
name = "tb3_1"
session = "live"
look = { mode = "stationary", scans = 5 }
place = { from = "odometry" }
"""


def parked(folder: Path) -> Recording:
    """A robot that stands at x = 0 for 24 revolutions, and then at x = 1 for 12; one revolution each 0.2 s."""
    places = [Motion(0.0, 0.0, 0.0)] * 2 + [Motion(1.0, 0.0, 3.0)]
    bench = bench_of(prism(CORNER))
    stops = [Standing(place, place, "as made") for place in places]
    return Recording(write(folder / "run.mcap", messages(bench, stops, np.random.default_rng(0))), RosTypes())


def taken(folder: Path, table: list[PoseRow]) -> list[tuple[int, str | None]]:
    """Numbers of the looks of the parked robot, with their poses."""
    looks = looks_of(parked(folder), SCENARIO, load(ROBOT), table)
    return [(each.number, None if each.row is None else each.row.pose) for each in looks]


def test_each_time_of_the_table_gives_a_look_of_a_robot_that_never_moves(tmp_path: Path) -> None:
    begin_ns, end_ns = times_of(parked(tmp_path))
    assert end_ns - begin_ns == 35 * STEP_NS
    times = [("P1", 0, 9), ("", 10, 13), ("P2", 14, 23), ("P3", 24, 35)]
    rows = [
        PoseRow(line, pose, None, begin_ns + first * STEP_NS, begin_ns + last * STEP_NS, None)
        for line, (pose, first, last) in enumerate(times, start=2)
    ]
    assert taken(tmp_path, rows) == [(1, "P1"), (2, "P2"), (3, "P3")]
    assert taken(tmp_path, rows[2:]) == [(1, "P2"), (2, "P3")]


def test_looks_by_number_are_those_of_a_live_session(tmp_path: Path) -> None:
    rows = [PoseRow(2, "P2", None, None, None, 2)]
    assert taken(tmp_path, rows) == [(1, None), (2, "P2")]


def look(number: int, pose: str | None, nearest: float = 0.5, **place: Any) -> TimedLook:
    scan = Scan(ranges=[nearest, 0.5, 0.5, 0.5], angle_min=0.0, angle_increment=0.1)
    where = place or {"sensor": "Q1"}
    if "x" in where:
        where = {"sensor_pose": UncertainSensorPose(**({"y": 0.0, "yaw_rad": 0.0} | where))}
    row = None if pose is None else PoseRow(number + 1, pose, None, None, None, number)
    return TimedLook(number, 0.1 * number, "lidar", ScanRequest(scan=scan, **where), row)


def test_a_look_near_a_listed_place_is_from_there_and_another_makes_its_own() -> None:
    scans = experiment_scans(
        [look(1, "P1", x=0.03), look(2, "P1", x=0.5), look(3, "P2", x=0.52), look(4, "P2", x=1.0, yaw_rad=2.0)],
        SCENARIO,
    )
    assert [sensor.name for sensor in scans.sensors] == ["Q1", "place 1", "place 2"]
    assert set(scans.measured) == {("Q1", "P1"), ("place 1", "P1"), ("place 1", "P2"), ("place 2", "P2")}
    assert scans.looks[0].off_m == pytest.approx(0.03)


def test_of_two_looks_at_one_pose_from_one_place_the_last_counts() -> None:
    scans = experiment_scans([look(1, "P1", 0.3), look(2, "P1", 0.4)], SCENARIO)
    assert scans.measured["Q1", "P1"][0] == 0.4
    assert [each.unused for each in scans.looks] == ["look 2 is of the same pose and place, and the last counts", None]


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (look(1, None), "the table states no pose for it"),
        (look(1, "upright"), "line 2 of the table: the scenario has no pose 'upright', only P1, P2, P3"),
        (look(1, "P1", sensor="Q9"), "no sensor configuration 'Q9', only Q1, Q2"),
    ],
)
def test_a_look_that_cannot_be_used_says_why(wrong: TimedLook, says: str) -> None:
    scans = experiment_scans([wrong, look(2, "P2")], SCENARIO)
    assert says in str(scans.looks[0].unused)
    assert set(scans.measured) == {("Q1", "P2")}
    with pytest.raises(VoaClientError, match="none of the 1 looks can be used"):
        experiment_scans([wrong], SCENARIO)


def test_a_table_whose_times_have_no_look_says_so() -> None:
    with pytest.raises(VoaClientError, match="check the times"):
        experiment_scans([], SCENARIO)
