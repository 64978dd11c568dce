"""Robots that park, drive, creep and are restarted, turn by turn."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count, pairwise
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.scale import scaled
from tests.voa_ros.ros_messages import scan, scans
from voa_msgs.base import Message
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.grids import BeamGrid
from voa_ros.look_taker import PARKED, LookTaker
from voa_ros.looks import GatheredLook, Waiting, Where, robot_of
from voa_ros.messages import LaserScan, Stamp
from voa_ros.robots import LookRule
from voa_ros.tracks import NoPose

INF, NAN = math.inf, math.nan
BEAMS = 90
SCANS = 5
GRID = BeamGrid(BEAMS, 0.0, math.tau / BEAMS)


def at(x: float = 0.0, y: float = 0.0, yaw_rad: float = 0.0) -> UncertainSensorPose:
    return UncertainSensorPose(x=x, y=y, yaw_rad=yaw_rad)


def room(x: float = 0.0, y: float = 0.0, turned: int = 0) -> list[float]:
    """Ranges of a lidar at a place in a room of 3 m by 2 m with a box."""
    ranges = []
    for beam in range(BEAMS):
        angle = math.tau * (beam + turned) / BEAMS
        cos, sin = math.cos(angle), math.sin(angle)
        walls = [
            ((1.5 if cos > 0 else -1.5) - x) / cos if cos else INF,
            ((1.0 if sin > 0 else -1.0) - y) / sin if sin else INF,
        ]
        box = 0.4 - x if abs(math.remainder(angle, math.tau)) < 0.2 else INF
        ranges.append(min(*walls, box))
    return ranges


@dataclass
class Robot:
    """Sends the revolutions of an LDS-01 to a taker; keeps what came of them."""

    taker: LookTaker
    noise: float = 0.035
    lost: float = 0.05
    chance: Random = field(default_factory=lambda: Random(7))  # noqa: S311  # noise, not a secret
    turns: Iterator[int] = field(default_factory=lambda: count(1))
    looks: list[GatheredLook] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)

    def measured(self, ranges: Iterable[float]) -> tuple[float, ...]:
        noisy = [value * (1.0 + self.chance.gauss(0.0, self.noise)) for value in ranges]
        if len(noisy) >= 6 and self.chance.random() < self.lost:
            start = self.chance.randrange(len(noisy) // 6) * 6
            noisy[start : start + 6] = [0.0] * 6
        return tuple(noisy)

    def scan(self, ranges: Iterable[float]) -> LaserScan:
        return scan(*self.measured(ranges), at=0.2 * next(self.turns), increment=math.tau / BEAMS)

    def turn(self, where: Where | NoPose, ranges: Iterable[float] | None = None) -> GatheredLook | Waiting:
        return self.send(self.scan(room() if ranges is None else ranges), where)

    def send(self, measured: LaserScan, where: Where | NoPose) -> GatheredLook | Waiting:
        answer = self.taker.receive(measured, where)
        if isinstance(answer, GatheredLook):
            self.looks.append(answer)
        else:
            self.reasons.append(answer.reason)
        return answer


def robot(mode: str = "stationary", **more: object) -> Robot:
    return Robot(LookTaker("tb3_1", LookRule.model_validate({"mode": mode, "scans": SCANS, **more}), GRID))


def last_reason(own: Robot) -> str:
    assert own.reasons[-1] == own.taker.waiting_for
    return own.reasons[-1]


# --- by a measured pose


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


def irregular(own: Robot, chance: Random) -> LaserScan:
    """A revolution of an LDS-02 or LD19: another number of beams, first angle and increment than the one before."""
    beams = chance.randrange(2 * BEAMS - 5, 2 * BEAMS + 5)
    increment = math.tau / beams
    first = chance.uniform(-0.5, 0.5) * increment
    ranges = [1.0 + 0.5 * math.cos(first + beam * increment) for beam in range(beams)]
    measured = scan(*own.measured(ranges), at=0.2 * next(own.turns), increment=increment)
    return replace(measured, angle_min=first, angle_max=first + (beams - 1) * increment)


@pytest.mark.parametrize("where", [at(), "E"])
def test_beams_that_differ_from_turn_to_turn_are_a_look_on_the_scenarios_grid(where: Where) -> None:
    own, chance = robot(), Random(3)  # noqa: S311  # noise, not a secret
    own.noise = 0.01
    for _ in range(100):
        own.send(irregular(own, chance), where)
    (look,) = own.looks
    taken = look.request.scan
    assert (len(taken.ranges), taken.angle_min, taken.angle_increment) == (BEAMS, GRID.angle_min, GRID.angle_increment)
    for beam, value in enumerate(taken.ranges):
        assert value == pytest.approx(1.0 + 0.5 * math.cos(GRID.angle_min + beam * GRID.angle_increment), abs=0.1)


def test_a_common_grid_is_kept() -> None:
    own = robot()
    measured = [replace(own.scan([1.0] * 50), angle_min=0.3) for _ in range(SCANS)]
    for each in measured:
        own.send(each, at())
    (look,) = own.looks
    taken = look.request.scan
    assert (len(taken.ranges), taken.angle_min) == (50, 0.3)


@pytest.mark.parametrize("where", [at(), "E"])
@pytest.mark.parametrize("value", [INF, 0.0, NAN])
@pytest.mark.parametrize("half", ["in turn", "by chance", "by sectors"])
def test_beams_that_answer_now_and_then_are_no_motion(where: Where, value: float, half: str) -> None:
    own, chance = robot(scans=10), Random(5)  # noqa: S311  # noise, not a secret
    own.noise = 0.01
    for turn in range(200):
        silent = {
            "in turn": [(beam + turn) % 2 == 0 for beam in range(BEAMS)],
            "by chance": [chance.random() < 0.5 for _ in range(BEAMS)],
            "by sectors": [(beam + 9 * turn) % BEAMS < BEAMS // 2 for beam in range(BEAMS)],
        }[half]
        own.turn(where, [value if off else seen for off, seen in zip(silent, room(), strict=True)])
    (look,) = own.looks
    compared = [
        (value, seen)
        for value, seen in zip(look.request.scan.ranges, room(), strict=True)
        if value is not None and value > 0.0
    ]
    assert len(compared) >= BEAMS / 2
    assert sum(abs(value - seen) > 0.1 for value, seen in compared) <= 4  # at the box's edges
    assert len(look.request.scan.no_return) <= BEAMS / 10


@pytest.mark.parametrize("where", [at(), "E"])
def test_lost_packets_are_no_motion(where: Where) -> None:
    own = robot(scans=10)
    for _ in range(200):
        ranges = room()
        for packet in range(BEAMS // 6):
            if own.chance.random() < 0.3:
                ranges[6 * packet : 6 * packet + 6] = [0.0] * 6
        own.turn(where, ranges)
    assert len(own.looks) == 1


# --- what a look is


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


# --- modes


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


# --- by the scene


def test_somebody_who_walks_by_makes_no_second_look() -> None:
    own = robot()
    for step in range(200):
        ranges = room()
        for beam in range(20):  # 80 degrees
            ranges[(beam + step) % BEAMS] = 0.3
        own.turn("E", ranges)
    assert len(own.looks) == 1


def test_a_lidar_that_is_turned_and_comes_to_rest_looks_again() -> None:
    own = robot()
    for turned in [0] * 20 + list(range(0, 30, 3)) + [30] * 20:
        own.turn("E", room(turned=turned))
    assert len(own.looks) == 2


def test_a_lidar_that_is_being_carried_does_not_look() -> None:
    own = robot(scans=10)
    for step in range(30):
        own.turn("E", room(x=-1.2 + 0.08 * step))
    assert own.looks == []


def test_a_short_change_of_the_scene_is_none() -> None:
    own = robot()
    for step in range(100):
        own.turn("E", [0.3] * BEAMS if 40 <= step < 44 else room())
    assert len(own.looks) == 1


def test_another_name_is_another_place() -> None:
    own = robot()
    for name in ("E", "N", "E"):
        for _ in range(20):
            own.turn(name)
    assert [look.request.sensor for look in own.looks] == ["E", "N", "E"]


def test_lost_packets_are_not_in_a_look() -> None:
    own = robot()
    own.noise, own.lost = 0.0, 0.4
    for _ in range(30):
        own.turn("E")
    assert own.looks[0].request.scan.ranges == pytest.approx(room(), abs=1e-6)


# --- looks that are not accepted


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


# --- every scan of a parked robot


@pytest.mark.parametrize("where", [at(), "E"])
def test_a_parked_robot_whose_every_scan_is_a_look_is_noticed(where: Where) -> None:
    own = robot("every")
    for turn in range(20):
        own.turn(where)
        assert own.taker.parked == (turn + 1 >= PARKED)
    for _ in range(2):
        own.turn(at(5.0))
        assert not own.taker.parked


# --- after a restart


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
