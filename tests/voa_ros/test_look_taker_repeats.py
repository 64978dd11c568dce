"""Look taker after looks that were not accepted, after a restart, and beside other processes."""

import math

import pytest

from tests.voa_ros.ros_messages import scan
from tests.voa_ros.standing import BEAMS, SCANS, at, last_reason, robot, room
from voa_msgs.sessions import ScanRequest
from voa_ros.looks import Where, robot_of


@pytest.mark.parametrize("where", [at(), "E"])
def test_a_look_that_is_not_accepted_does_not_use_up_the_stop(where: Where) -> None:
    own = robot()
    for attempt in range(1, 4):
        for _ in range(SCANS):
            own.turn(where)
        assert len(own.looks) == attempt
        own.taker.rejected("no_beams")
        assert own.taker.waiting_for == (
            f"standing still: 0 of {SCANS} revolutions; the last look was not accepted (no_beams)"
        )
    for _ in range(50):
        own.turn(where)
    assert len(own.looks) == 4
    assert own.taker.waiting_for == "the robot to move on: this stop's look is taken"


def test_a_request_is_not_used_up_either() -> None:
    own = robot("on_request")
    own.taker.request()
    for _ in range(SCANS):
        own.turn(at())
    own.taker.rejected("nothing_seen")
    assert own.taker.requested
    for _ in range(20):
        own.turn(at())
    assert len(own.looks) == 2
    assert own.taker.waiting_for == "a request"


def test_the_reason_is_forgotten_when_the_robot_moves() -> None:
    own = robot()
    for _ in range(SCANS):
        own.turn(at())
    own.taker.rejected("no_beams")
    own.turn(at(1.0))
    own.turn(at(2.0))
    assert own.taker.waiting_for == "the robot to stop"


def test_an_answer_that_comes_when_the_robot_has_moved_on_disturbs_no_stop() -> None:
    own = robot()
    for _ in range(SCANS):
        own.turn(at())
    for _ in range(3 + SCANS - 1):
        own.turn(at(1.0))
    own.taker.rejected("no_beams")
    own.turn(at(1.0))
    assert len(own.looks) == 2


def test_an_answer_about_an_earlier_look_takes_no_look_twice() -> None:
    own = robot()
    for x in (0.0, 1.0):
        for _ in range(3 + SCANS):
            own.turn(at(x))
    first, second = own.looks
    own.taker.rejected("no_beams", first.request)
    for _ in range(50):
        own.turn(at(1.0))
    assert len(own.looks) == 2
    own.taker.rejected("no_beams", second.request)
    for _ in range(50):
        own.turn(at(1.0))
    assert len(own.looks) == 3


@pytest.mark.parametrize("where", [at(), "E"])
def test_a_look_that_equals_the_one_before_uses_up_its_stop_too(where: Where) -> None:
    """Without stamps and noise, a robot that comes back sees to the last bit what it saw before."""
    own = robot()
    measured = scan(*room(), increment=math.tau / BEAMS)
    for stop in range(3):
        for _ in range(5 * SCANS):
            own.send(measured, where)
        assert len(own.looks) == stop + 1
        for _ in range(3):
            own.send(measured, at(5.0))
    assert own.looks[0] == own.looks[1] == own.looks[2]


@pytest.mark.parametrize("where", [at(1.0, 2.0, 3.0), "E"])
def test_a_robot_that_is_still_where_it_looked_has_had_its_look(where: Where) -> None:
    before = robot()
    for _ in range(20):
        before.turn(where)
    stored = ScanRequest.model_validate_json(before.looks[0].request.model_dump_json())
    after = robot()
    after.taker.resume(stored)
    for _ in range(100):
        after.turn(where)
    assert after.looks == []
    assert last_reason(after) == "the robot to move on: this stop's look is taken"


@pytest.mark.parametrize(("where", "elsewhere"), [(at(1.0), at(2.0)), ("E", "N"), ("E", at()), (at(), "E")])
def test_a_robot_that_is_elsewhere_looks(where: Where, elsewhere: Where) -> None:
    before, after = robot(), robot()
    for _ in range(20):
        before.turn(where)
    after.taker.resume(before.looks[0].request)
    for _ in range(20):
        after.turn(elsewhere)
    assert len(after.looks) == 1


def test_a_robot_that_is_before_another_scene_looks() -> None:
    before, after = robot(), robot()
    for _ in range(20):
        before.turn("E")
    after.taker.resume(before.looks[0].request)
    for _ in range(20):
        after.turn("E", room(turned=30))
    assert len(after.looks) == 1


def test_the_look_of_another_process_is_this_stops_look() -> None:
    one, other = robot(), robot()
    one.turn(at())  # the other joins a revolution later
    for _ in range(SCANS - 1):
        measured = one.scan(room())
        one.send(measured, at())
        other.send(measured, at())
    other.taker.resume(one.looks[0].request)
    for _ in range(20):
        other.turn(at())
    assert other.looks == []


def test_to_resume_from_a_look_again_changes_nothing() -> None:
    own = robot()
    for _ in range(20):
        own.turn(at())
    for _ in range(3 + SCANS - 1):
        own.taker.resume(own.looks[0].request)
        own.turn(at(x=1.0))
    assert len(own.looks) == 2


def test_a_scan_that_is_no_look_names_no_robot() -> None:
    own = robot("every")
    own.turn("E", [1.0])
    request = own.looks[0].request
    for stamp in (None, "tb3_1", {"robot": 3}, {"sec": 1}):
        assert robot_of(request.model_copy(update={"scan": request.scan.model_copy(update={"stamp": stamp})})) is None
