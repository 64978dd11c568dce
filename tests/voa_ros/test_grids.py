"""Beams brought onto a grid, against a brute-force search by angles."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import scan
from voa_ros.cdr import decode_laser_scan, encode_laser_scan
from voa_ros.grids import GRID_WITHIN_RAD, BeamGrid, aligned, binned, grid_of, on_grid, same_grid, upside_down
from voa_ros.messages import LaserScan

NAN, INF = math.nan, math.inf
TURN = BeamGrid(360, 0.0, math.tau / 360)


def layout(beams: int, angle_min: float, increment: float, first_value: float = 1.0) -> LaserScan:
    """A scan whose beam `i` says `first_value + i`."""
    ranges = tuple(first_value + beam for beam in range(beams))
    last = angle_min + (beams - 1) * increment
    return replace(scan(*ranges), angle_min=angle_min, angle_max=last, angle_increment=increment)


def angles(scan_: LaserScan) -> list[float]:
    return [scan_.angle_min + beam * scan_.angle_increment for beam in range(len(scan_.ranges))]


def offs(parts: list[LaserScan], angle: float) -> dict[float, float]:
    """Distance of each measured beam from an angle, radians, by its value; all values differ."""
    return {
        value: abs(math.remainder(own - angle, math.tau))
        for part in parts
        for own, value in zip(angles(part), part.ranges, strict=True)
    }


INCREMENTS = st.floats(math.radians(0.2), math.radians(40.0)).flatmap(lambda step: st.sampled_from([step, -step]))


@st.composite
def grids(draw: st.DrawFn) -> BeamGrid:
    step = draw(INCREMENTS)
    most = int(math.tau / abs(step)) + 1  # one more than a turn has: the last may point where the first does
    return BeamGrid(draw(st.integers(1, min(most, 60))), draw(st.floats(-4.0, 7.0)), step)


LAYOUTS = grids().map(lambda grid: layout(grid.beams, grid.angle_min, grid.angle_increment))


@given(st.lists(LAYOUTS, min_size=1, max_size=3), grids())
def test_each_beam_takes_the_nearest_within_half_an_increment(measured: list[LaserScan], grid: BeamGrid) -> None:
    parts = [
        replace(part, ranges=tuple(1_000.0 * number + value for value in part.ranges))
        for number, part in enumerate(measured)
    ]
    ranges = binned(parts, grid)
    assert len(ranges) == grid.beams
    half = abs(grid.angle_increment) / 2.0
    for beam, value in enumerate(ranges):
        off = offs(parts, grid.angle_min + beam * grid.angle_increment)
        nearest = min(off.values())
        if value is None:
            assert nearest > half
        else:
            assert off[value] <= half + GRID_WITHIN_RAD
            assert off[value] <= nearest + 1e-9


@given(LAYOUTS)
def test_a_scan_on_its_own_grid_is_itself(measured: LaserScan) -> None:
    grid = grid_of(measured)
    assume(grid.beams * abs(grid.angle_increment) <= math.tau)
    assert tuple(binned([measured], grid)) == measured.ranges
    assert same_grid(on_grid([measured], grid), measured)


@pytest.mark.parametrize("turns", [-2, -1, 1, 2])
def test_a_turn_more_or_less_is_the_same_angle(turns: int) -> None:
    measured = layout(40, 0.3, math.tau / 40)
    assert binned([replace(measured, angle_min=0.3 + turns * math.tau)], TURN) == binned([measured], TURN)


def test_beams_half_an_increment_off_leave_none_empty() -> None:
    """Every beam of the grid lies half way between two measured ones."""
    measured = layout(360, math.tau / 720, math.tau / 360)
    for sent in (measured, decode_laser_scan(encode_laser_scan(measured))):
        ranges = binned([sent], TURN)
        assert None not in ranges
        assert all(value in (beam, beam + 1, beam + 360) for beam, value in enumerate(ranges))


def test_a_negative_increment_runs_the_other_way() -> None:
    measured = layout(4, math.tau / 4, -math.tau / 4)  # at 90, 0, -90 and 180 degrees
    assert binned([measured], BeamGrid(4, 0.0, math.tau / 4)) == [2.0, 1.0, 4.0, 3.0]
    assert binned([measured], BeamGrid(4, 0.0, -math.tau / 4)) == [2.0, 3.0, 4.0, 1.0]


def test_a_grid_of_some_angles_takes_only_those() -> None:
    front = BeamGrid(3, -math.tau / 8, math.tau / 8)
    measured = layout(8, 0.0, math.tau / 8)
    assert binned([measured], front) == [8.0, 1.0, 2.0]
    assert binned([layout(2, 0.0, math.tau / 8)], front) == [None, 1.0, 2.0]
    assert binned([layout(3, 3.0, 0.1)], front) == [None] * 3


def test_a_last_beam_that_points_where_the_first_does_has_its_value_too() -> None:
    """The driver of the LDS-02 spreads its beams over [0, 2 pi], both ends included."""
    both_ends = BeamGrid(5, 0.0, math.tau / 4)
    ranges = binned([layout(4, 0.0, math.tau / 4)], both_ends)
    assert ranges == [1.0, 2.0, 3.0, 4.0, 1.0]


def test_finer_beams_are_thinned_and_coarser_ones_leave_gaps() -> None:
    assert binned([layout(1_440, 0.0, math.tau / 1_440)], TURN) == [1.0 + 4 * beam for beam in range(360)]
    ranges = binned([layout(90, 0.0, math.tau / 90)], TURN)
    assert [beam for beam, value in enumerate(ranges) if value is not None] == list(range(0, 360, 4))


def test_values_pass_as_they_are() -> None:
    measured = replace(scan(INF, 0.0, NAN, -INF, increment=math.tau / 4))
    assert repr(tuple(binned([measured], BeamGrid(4, 0.0, math.tau / 4)))) == repr(measured.ranges)


def test_a_scan_on_a_grid_says_so_in_its_header() -> None:
    parts = [layout(90, 0.0, math.radians(1.0)), layout(90, math.radians(90.0), math.radians(1.0), 91.0)]
    parts = [replace(part, intensities=(1.0,)) for part in parts]
    whole = on_grid(parts, BeamGrid(180, 0.0, math.radians(1.0)))
    assert whole.ranges == tuple(1.0 + beam for beam in range(180))
    assert (whole.angle_min, whole.angle_increment, whole.intensities) == (0.0, math.radians(1.0), ())
    assert whole.angle_max == pytest.approx(math.radians(179.0))
    assert (whole.stamp, whole.frame_id, whole.scan_time) == (parts[0].stamp, "base_scan", 0.25)


@pytest.mark.parametrize(
    ("change", "same"),
    [
        ({}, True),
        ({"angle_min": 0.00009}, True),
        ({"angle_min": 0.00011}, False),
        ({"angle_increment": math.tau / 360 + 2e-7}, True),
        ({"angle_increment": math.tau / 360 + 4e-7}, False),  # 1.4e-4 rad at the last beam
        ({"ranges": (1.0,) * 359}, False),
    ],
)
def test_scans_have_the_same_beams_within_a_tenth_of_a_milliradian(change: dict[str, object], same: bool) -> None:
    measured = layout(360, 0.0, math.tau / 360)
    assert same_grid(measured, replace(measured, **change)) == same  # type: ignore[arg-type] # fields of several types
    assert same_grid(replace(measured, **change), measured) == same  # type: ignore[arg-type] # fields of several types


def test_two_scans_are_compared_as_they_are_where_their_beams_are_the_same() -> None:
    one, other = layout(4, 0.3, math.tau / 4), layout(4, 0.3, math.tau / 4, 5.0)
    assert aligned(one, other, TURN) == (one.ranges, other.ranges)
    turned = replace(other, angle_min=0.3 + math.tau / 8)
    on_turn = aligned(one, turned, BeamGrid(8, 0.3, math.tau / 8))
    assert repr(on_turn) == repr(((1.0, NAN, 2.0, NAN, 3.0, NAN, 4.0, NAN), (NAN, 5.0, NAN, 6.0, NAN, 7.0, NAN, 8.0)))


@given(LAYOUTS)
def test_upside_down_twice_is_upright(measured: LaserScan) -> None:
    again = upside_down(upside_down(measured))
    assert again.ranges == measured.ranges
    assert again.angle_increment == measured.angle_increment
    assert (again.angle_min, again.angle_max) == pytest.approx((measured.angle_min, measured.angle_max), abs=1e-9)


@given(LAYOUTS)
def test_upside_down_mirrors_the_angles(measured: LaserScan) -> None:
    measured = replace(measured, intensities=measured.ranges)
    over = upside_down(measured)
    before = dict(zip(measured.ranges, angles(measured), strict=True))
    for value, angle in zip(over.ranges, angles(over), strict=True):
        assert angle == pytest.approx(-before[value], abs=1e-9)
    assert over.intensities == over.ranges
    assert over.angle_max == pytest.approx(angles(over)[-1], abs=1e-9)
