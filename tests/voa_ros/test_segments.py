"""Segments of a picoScan and its like, joined into turns."""

import math
from collections.abc import Iterable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import scan
from voa_ros.grids import BeamGrid
from voa_ros.messages import LaserScan, Stamp
from voa_ros.segments import MOST_SEGMENTS, PARTIAL_SHARE, JoinedScan, SegmentJoiner

GRID = BeamGrid(360, -math.pi, math.tau / 360)
SEGMENTS = 12
BEAMS = 60
"""Beams of a segment, half a degree each."""
PERIOD_S = 0.1


def segment(number: int, of: int = SEGMENTS, value: float = 1.0) -> LaserScan:
    """Segment `number` since the start of a lidar that turns ten times a second, all beams with one value."""
    part = number % of
    step = math.tau / of / BEAMS
    low = -math.pi + part * BEAMS * step
    return replace(
        scan(*[value] * BEAMS, at=10.0 + PERIOD_S * number / of),
        angle_min=low,
        angle_max=low + (BEAMS - 1) * step,
        angle_increment=step,
        scan_time=PERIOD_S / of,
    )


def gatherer(first: int = 0, of: int = SEGMENTS, grid: BeamGrid = GRID) -> SegmentJoiner[int]:
    """A gatherer that has passed the very first segment on: the one opposite to the first that follows."""
    own: SegmentJoiner[int] = SegmentJoiner(grid)
    opposite = segment(first + of // 2, of)
    assert own.receive(opposite, -1, 0.0) == JoinedScan(opposite, -1)
    return own


def gathered(own: SegmentJoiner[int], numbers: Iterable[int], of: int = SEGMENTS) -> list[JoinedScan[int]]:
    turns = [own.receive(segment(number, of, 1.0 + number), number, PERIOD_S * number / of) for number in numbers]
    return [turn for turn in turns if turn is not None]


def values(turn: JoinedScan[int]) -> set[float]:
    return {value for value in turn.scan.ranges if not math.isnan(value)}


@pytest.mark.parametrize("of", [4, 9, 12, 36])
def test_segments_become_turns(of: int) -> None:
    turns = gathered(gatherer(0, of), range(3 * of), of)
    assert [turn.message for turn in turns] == [of - 1, 2 * of - 1, 3 * of - 1]
    for number, turn in enumerate(turns):
        first = segment(number * of, of)
        assert (len(turn.scan.ranges), turn.scan.angle_min, turn.scan.angle_increment) == (
            GRID.beams,
            GRID.angle_min,
            GRID.angle_increment,
        )
        assert values(turn) == {1.0 + segment for segment in range(number * of, (number + 1) * of)}
        assert not any(map(math.isnan, turn.scan.ranges))
        assert turn.scan.stamp == first.stamp
        assert turn.scan.scan_time == pytest.approx(PERIOD_S)


@given(st.integers(0, SEGMENTS - 1))
def test_a_turn_may_begin_anywhere(start: int) -> None:
    turns = gathered(gatherer(start), range(start, start + 2 * SEGMENTS))
    assert len(turns) == 2
    assert all(not any(map(math.isnan, turn.scan.ranges)) for turn in turns)


@given(st.sets(st.integers(0, 5 * SEGMENTS - 1), max_size=20))
def test_lost_segments_leave_gaps_and_mix_no_more_than_two_turns(lost: set[int]) -> None:
    left = [number for number in range(5 * SEGMENTS) if number not in lost]
    turns = gathered(gatherer(left[0]), left)
    seen: set[float] = set()
    for turn in turns:
        assert not seen & values(turn)  # no segment is in two turns
        seen |= values(turn)
        assert max(values(turn)) - min(values(turn)) < 2 * SEGMENTS
    assert len(turns) >= 4 - len(lost) // SEGMENTS - 1
    kept = {number for number in left if number < 4 * SEGMENTS} - {int(value) - 1 for value in seen}
    assert len(kept) < SEGMENTS  # those of the last turn that is not complete


def test_a_lost_segment_is_a_gap_of_its_own_angles() -> None:
    (turn,) = gathered(gatherer(), (number for number in range(SEGMENTS + 1) if number != 3))
    gap = [beam for beam, value in enumerate(turn.scan.ranges) if math.isnan(value)]
    assert gap == list(range(90, 120)) or gap == list(range(91, 120))
    assert turn.message == SEGMENTS - 1


def test_what_is_so_far_is_counted() -> None:
    own = gatherer()
    assert own.segments == 0
    gathered(own, range(5))
    assert own.segments == 5
    gathered(own, range(5, SEGMENTS))
    assert own.segments == 0


def test_segments_before_a_pause_are_of_another_turn() -> None:
    own = gatherer()
    gathered(own, range(6))
    after = range(60 * SEGMENTS + 6, 61 * SEGMENTS + 6)  # six seconds on, the other half first
    (turn,) = gathered(own, after)
    assert values(turn) == {1.0 + number for number in after}


@pytest.mark.parametrize("share", [PARTIAL_SHARE, 0.9, 1.0, 1.003])
def test_scans_of_the_whole_turn_pass_at_once(share: float) -> None:
    own: SegmentJoiner[str] = SegmentJoiner(GRID)
    beams = math.ceil(360 * share)
    measured = replace(scan(*[1.0] * beams), angle_min=0.0, angle_increment=math.tau / 360)
    for name in ("a", "b"):
        assert own.receive(measured, name, 0.0) == JoinedScan(measured, name)
    assert own.segments == 0


def test_a_whole_turn_ends_what_was_gathered() -> None:
    own = gatherer()
    gathered(own, range(3))
    assert own.segments == 3
    own.receive(replace(scan(*[1.0] * 360), angle_min=0.0), 3, 0.1)
    assert own.segments == 0


def test_a_lidar_of_a_quarter_turn_passes_at_once() -> None:
    own: SegmentJoiner[int] = SegmentJoiner(GRID)
    measured = [replace(scan(*[1.0 + number] * 90), stamp=Stamp(number), angle_min=-0.8) for number in range(5)]
    turns = [own.receive(each, number, float(number)) for number, each in enumerate(measured)]
    assert turns == [JoinedScan(each, number) for number, each in enumerate(measured)]


def test_a_lidar_whose_scenario_is_a_quarter_turn_passes_at_once() -> None:
    own: SegmentJoiner[int] = SegmentJoiner(BeamGrid(90, -math.pi / 4, math.tau / 360))
    measured = replace(scan(*[1.0] * 90), angle_min=-math.pi / 4)
    assert own.receive(measured, 0, 0.0) == JoinedScan(measured, 0)


@pytest.mark.parametrize("of", [4, 12])
def test_segments_beside_the_scenarios_angles_complete_no_turn(of: int) -> None:
    """The scenario's lidar sees the front quarter, the robot's all round: only the front segments count."""
    front = BeamGrid(90, -math.pi / 4 + math.radians(0.5), math.tau / 360)
    turns = gathered(gatherer(0, of, front), range(4 * of), of)
    assert len(turns) >= 3
    for turn in turns:
        if len(turn.scan.ranges) == front.beams:
            assert sum(map(math.isnan, turn.scan.ranges)) <= 1


def test_angles_are_compared_modulo_a_turn() -> None:
    turns = gathered(gatherer(grid=BeamGrid(360, 0.0, math.tau / 360)), range(2 * SEGMENTS))
    assert [turn.message for turn in turns] == [SEGMENTS - 1, 2 * SEGMENTS - 1]
    own, one = gatherer(), segment(0)
    assert own.receive(one, 0, 0.0) is None
    assert own.receive(segment(3), 1, 0.0) is None
    assert own.receive(replace(one, angle_min=one.angle_min + math.tau), 2, 0.1) is not None


def test_segments_that_overlap_a_little_are_segments_in_every_turn() -> None:
    own = gatherer()
    wide = [replace(one, ranges=one.ranges + one.ranges[:9]) for one in map(segment, range(5 * SEGMENTS))]
    turns = [own.receive(one, number, 0.1 * number) for number, one in enumerate(wide)]
    complete = [turn for turn in turns if turn is not None]
    assert len(complete) >= 4
    assert all(len(turn.scan.ranges) == GRID.beams for turn in complete)
    assert all(sum(map(math.isnan, turn.scan.ranges)) <= 60 for turn in complete)


def test_the_message_of_a_turn_with_a_gap_is_that_of_its_last_segment() -> None:
    """Check that a revolution ends when a segment of the next one arrives."""
    (turn,) = gathered(gatherer(), [0, 1, 2, 3, SEGMENTS])
    assert (turn.message, values(turn)) == (3, {1.0, 2.0, 3.0, 4.0})


@pytest.mark.parametrize("stamp", [Stamp(), Stamp(7)])
def test_stamps_that_lie_do_not_spoil_the_time_of_a_turn(stamp: Stamp) -> None:
    own = gatherer()
    answers = [own.receive(replace(segment(number), stamp=stamp), number, 0.0) for number in range(SEGMENTS)]
    turn = answers[-1]
    assert turn is not None
    assert 0.0 <= turn.scan.scan_time <= PERIOD_S


def test_segments_without_end_take_no_memory() -> None:
    own: SegmentJoiner[int] = SegmentJoiner(BeamGrid(10_000, 0.0, math.tau / 10_000))
    for number in range(4 * MOST_SEGMENTS):
        own.receive(replace(scan(1.0, increment=1e-5), angle_min=1e-4 * number), number, 0.0)
        assert own.segments <= MOST_SEGMENTS
