"""Modes of a look taker, what a look contains, and stops that are recognised by a measured pose."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.scale import scaled
from tests.voa_ros.ros_messages import scans
from tests.voa_ros.standing import INF, NAN, SCANS, at, last_reason, robot, room
from voa_msgs.base import Message
from voa_msgs.sessions import ScanRequest
from voa_ros.look_taker import PARKED
from voa_ros.looks import Where, robot_of
from voa_ros.messages import LaserScan, Stamp
from voa_ros.tracks import NoPose


@pytest.mark.parametrize("seed", range(scaled(3, 20)))
@pytest.mark.parametrize("where", [at(0.1, 0.2, 3.0), "E"])
def test_a_robot_that_is_parked_looks_once(where: Where, seed: int) -> None:
    own = robot()
    own.chance.seed(seed)
    for _ in range(1_000):
        own.turn(where)
    assert len(own.looks) == 1
    assert last_reason(own) == "the robot to move on: this stop's look is taken"


@given(
    st.lists(st.tuples(st.floats(-0.0017, 0.0017), st.floats(-0.0017, 0.0017), st.floats(-0.004, 0.004)), max_size=60)
)
def test_jitter_below_the_threshold_is_standing_still(jitter: list[tuple[float, float, float]]) -> None:
    own = robot()
    for x, y, yaw_rad in jitter:
        own.turn(at(1.0 + x, y, math.pi + yaw_rad), [1.0])
    assert len(own.looks) == (1 if len(jitter) >= SCANS else 0)


@settings(max_examples=scaled(30, 200))
@given(st.lists(st.tuples(st.integers(SCANS + 3, 30), st.integers(3, 20)), min_size=1, max_size=5))
def test_each_stop_is_a_look(legs: list[tuple[int, int]]) -> None:
    own = robot()
    x = 0.0
    stops = []
    for standing, driving in legs:
        for _ in range(standing):
            own.turn(at(x), [1.0])
        stops.append(x)
        for _ in range(driving):
            x += 0.04
            own.turn(at(x), [1.0])
    assert [look.request.sensor_pose.x for look in own.looks if look.request.sensor_pose] == pytest.approx(stops)


@pytest.mark.parametrize("turning", [False, True])
def test_a_robot_that_never_stops_never_looks(turning: bool) -> None:
    own = robot()
    for step in range(200):
        own.turn(at(yaw_rad=0.02 * step) if turning else at(x=0.02 * step))
    assert own.looks == []
    assert last_reason(own) == "the robot to stop"


def test_creeping_is_not_standing_still() -> None:
    own = robot(scans=10)
    for step in range(300):
        own.turn(at(x=0.001 * step))  # each step is well below the threshold of 5 mm
    assert own.looks == []


def test_creeping_away_from_a_look_ends_its_stop() -> None:
    own = robot()
    for step in range(200):
        own.turn(at(x=0.0005 * step))  # 2 mm from the first to the last revolution of a look
    taken = [look.request.sensor_pose.x for look in own.looks if look.request.sensor_pose]
    assert len(taken) == 5
    assert all(second - first > 0.02 for first, second in pairwise(taken))


def test_one_pose_that_is_off_makes_no_second_look() -> None:
    own = robot()
    for step in range(100):
        own.turn(at(x=0.5 if step % 10 == 7 else 0.0))
    assert len(own.looks) == 1


def test_what_is_waited_for_is_said() -> None:
    own = robot()
    assert own.taker.waiting_for == "a scan"
    own.turn(NoPose("no odometry was received yet"))
    assert last_reason(own) == "the lidar's pose: no odometry was received yet"
    for _ in range(SCANS - 1):
        own.turn(at())
    assert own.reasons[1:] == ["the robot to stop", *(f"standing still: {n} of {SCANS} revolutions" for n in (2, 3, 4))]
    own.turn(at())
    assert own.taker.waiting_for == "the robot to move on: this stop's look is taken"
    assert len(own.looks) == 1


def test_a_pose_that_is_missing_now_and_then_ends_no_stop() -> None:
    own = robot()
    for step in range(2 * SCANS):
        own.turn(NoPose("late") if step % 2 else at())
    assert len(own.looks) == 1


def test_a_look_is_the_median_at_the_mean_pose() -> None:
    own = robot(scans=3)
    own.noise = own.lost = 0.0
    for step, value in enumerate([1.0, 1.2, 1.1]):
        own.turn(at(0.002 * step, 1.0, math.pi + 0.003 * (step - 1)), [value, INF, 0.0, NAN])
    (look,) = own.looks
    pose, taken = look.request.sensor_pose, look.request.scan
    assert pose is not None
    assert (pose.x, pose.y) == pytest.approx((0.002, 1.0))
    assert abs(math.remainder(pose.yaw_rad - math.pi, math.tau)) < 1e-9
    assert (taken.ranges, taken.no_return) == ([1.1, None, 0.0, None], [1])
    assert taken.stamp == {
        "robot": "tb3_1",
        "from": {"sec": 0, "nanosec": 200_000_000},
        "to": {"sec": 0, "nanosec": 600_000_000},
        "scans": 3,
        "frame_id": "base_scan",
    }
    assert robot_of(look.request) == "tb3_1"


def test_two_processes_give_a_look_one_name() -> None:
    one, other = robot(), robot()
    for _ in range(SCANS):
        measured = one.scan(room())
        one.send(measured, at())
        other.send(measured, at())
    assert one.looks == other.looks
    assert len(one.looks) == 1


def test_a_robot_without_a_clock_names_looks_by_what_they_saw() -> None:
    own = robot()
    for x in (0.0, 1.0):
        for _ in range(SCANS + 3):
            own.send(replace(own.scan(room()), stamp=Stamp()), at(x))
    assert len({look.digest for look in own.looks}) == len(own.looks) == 2


@given(scans(), st.sampled_from(["every", "stationary", "on_request"]), st.sampled_from(["E", at()]))
def test_any_scan_can_be_part_of_a_look(measured: LaserScan, mode: str, where: Where) -> None:
    own = robot(mode, scans=2)
    if mode == "on_request":
        own.taker.request()
    for sec in range(1, 4):
        own.send(replace(measured, stamp=Stamp(sec)), where)
    for look in own.looks:
        assert len(look.digest) <= 255
        assert ScanRequest.model_validate_json(look.request.model_dump_json()) == look.request
    if isinstance(where, Message):
        assert len(own.looks) == (3 if mode == "every" else 1)


def test_every_scan_is_a_look_where_that_is_the_mode() -> None:
    own = robot("every")
    for step in range(20):
        own.turn(at(x=float(step)))
    assert len({look.digest for look in own.looks}) == 20
    assert own.taker.waiting_for is None
    own.turn(NoPose("late"))
    assert last_reason(own) == "the lidar's pose: late"


@pytest.mark.parametrize("where", [at(), "E"])
def test_a_request_gives_one_look(where: Where) -> None:
    own = robot("on_request")
    for looks in range(3):
        for _ in range(20):
            own.turn(where)
        assert len(own.looks) == looks
        assert last_reason(own) == "a request"
        own.taker.request()
        own.taker.request()
        assert own.taker.waiting_for == "the robot to stop"
        for _ in range(SCANS - 1):
            own.turn(where)
        assert len(own.looks) == looks
        own.turn(where)
        assert len(own.looks) == looks + 1


def test_a_request_waits_for_the_robot_to_stop() -> None:
    own = robot("on_request")
    own.taker.request()
    for step in range(20):
        own.turn(at(x=0.04 * step))
    assert own.looks == []
    for _ in range(SCANS):
        own.turn(at(x=5.0))
    assert len(own.looks) == 1


@pytest.mark.parametrize("mode", ["every", "stationary"])
def test_only_looks_on_request_are_requested(mode: str) -> None:
    with pytest.raises(ValueError, match=f"'tb3_1' is in mode '{mode}'"):
        robot(mode).taker.request()


@pytest.mark.parametrize("where", [at(), "E"])
def test_a_parked_robot_whose_every_scan_is_a_look_is_noticed(where: Where) -> None:
    own = robot("every")
    for turn in range(20):
        own.turn(where)
        assert own.taker.parked == (turn + 1 >= PARKED)
    for _ in range(2):
        own.turn(at(5.0))
        assert not own.taker.parked
