"""Look taker with irregular beams, and without a pose: stops that are recognised by comparing scans."""

import math
from dataclasses import replace
from random import Random

import pytest

from tests.voa_ros.ros_messages import scan
from tests.voa_ros.standing import BEAMS, GRID, INF, NAN, SCANS, Robot, at, robot, room
from voa_ros.looks import Where
from voa_ros.messages import LaserScan


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
