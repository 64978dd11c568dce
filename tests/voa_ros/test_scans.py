import math
import struct
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import FLOATS, scan, scans
from voa_msgs.sessions import Scan
from voa_ros.cdr import decode_laser_scan, encode_laser_scan
from voa_ros.grids import BeamGrid
from voa_ros.messages import LaserScan, Stamp
from voa_ros.scans import median_scan, scan_message

NAN, INF = math.nan, math.inf
GRID = BeamGrid(360, 0.0, math.tau / 360)


def float32(value: float) -> float:
    return float(struct.unpack("f", struct.pack("f", value))[0])


def test_each_beam_is_what_rep_117_makes_of_it() -> None:
    message = scan_message(scan(0.5, INF, NAN, -INF, 0.0, -0.0, -1.0, 9.0, 0.01))
    assert message.ranges == [0.5, None, None, None, 0.0, 0.0, None, 9.0, 0.01]
    assert message.no_return == [1]
    assert math.copysign(1.0, message.ranges[5] or 0.0) == 1.0


def test_float32s_noise_is_gone_and_the_grid_is_untouched() -> None:
    received = decode_laser_scan(encode_laser_scan(replace(scan(0.123, 0.12), range_min=0.12)))
    message = scan_message(received)
    assert received.ranges != (0.123, 0.12)
    assert (message.ranges, message.range_min, message.range_max) == ([0.123, 0.12], 0.12, 3.5)
    assert (message.angle_min, message.angle_increment) == (0.0, float32(math.tau / 360))


@pytest.mark.parametrize(("near", "far"), [(0.0, 0.0), (0.12, INF), (0.12, 1e30), (1.0, 1.0), (1.0, 1.0000001)])
def test_limits_that_say_nothing_are_the_lidars(near: float, far: float) -> None:
    message = scan_message(replace(scan(1.0), range_min=near, range_max=far))
    assert (message.range_min, message.range_max) == (None, None)


def test_the_stamp_is_kept() -> None:
    measured = replace(scan(1.0), stamp=Stamp(7, 8))
    assert scan_message(measured).stamp == {"sec": 7, "nanosec": 8, "frame_id": "base_scan"}
    assert scan_message(measured, {"scans": 3}).stamp == {"scans": 3}


@given(scans())
def test_any_scan_becomes_a_message_that_passes(measured: LaserScan) -> None:
    message = scan_message(decode_laser_scan(encode_laser_scan(measured)))
    assert Scan.model_validate_json(message.model_dump_json()) == message
    assert len(message.ranges) == len(measured.ranges)
    for index, value in enumerate(measured.ranges):
        assert (index in message.no_return) == (value == INF)
        assert (message.ranges[index] is None) == (not 0.0 <= value < INF)
        assert (message.ranges[index] == 0.0) == (value == 0.0)
        if 0.0 <= value < 1e3:
            assert message.ranges[index] == pytest.approx(value, abs=1e-6)


def median_of(values: Sequence[float]) -> float:
    return median_scan([scan(value) for value in values], GRID).ranges[0]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([1.0], 1.0),
        ([1.0, 3.0, 2.0], 2.0),
        ([1.0, 2.0], 1.0),
        ([1.0, 3.0, 0.0, 2.0], 2.0),  # a lost packet
        ([1.0, 0.0], 1.0),
        ([0.0, 0.0, 1.0], 0.0),  # nothing in range, and a stray return
        ([0.0, NAN, 0.0, 1.0, 2.0], 0.0),
        ([NAN, -INF, 0.0, 1.0, 2.0], NAN),
        ([NAN, NAN, 1.0, 1.0], 1.0),
        ([INF, 1.0, 1.0], 1.0),
        ([INF, 1.0], 1.0),  # a dark surface
        ([INF, INF, 1.0], NAN),  # an edge
        ([INF, INF, INF, 1.0], NAN),
        ([INF, INF, INF, INF, 1.0], INF),  # a stray return
        ([INF, NAN, NAN, INF], INF),
        ([INF, 0.0, NAN], 0.0),
        ([-1.0, -INF, 5.0], NAN),
        ([0.13, 0.13, 0.5, 0.5], 0.13),  # never in between
    ],
)
def test_the_median_of_a_beam(values: list[float], expected: float) -> None:
    median = median_of(values)
    assert math.isnan(median) if math.isnan(expected) else median == expected


@given(st.lists(FLOATS, min_size=1, max_size=9), st.randoms(use_true_random=False))
def test_the_median_does_not_depend_on_the_order_and_was_measured(values: list[float], random: Any) -> None:
    median = median_of(values)
    shuffled = list(values)
    random.shuffle(shuffled)
    assert repr(median_of(shuffled)).removeprefix("-") == repr(median).removeprefix("-")
    assert math.isnan(median) or median in values


def test_beams_are_taken_one_by_one() -> None:
    turns = [scan(1.0, 0.0, INF), scan(1.2, 0.0, INF), scan(1.1, 4.0, INF)]
    middle = median_scan([replace(turn, intensities=(1.0, 2.0, 3.0)) for turn in turns], GRID)
    assert middle == replace(turns[0], ranges=(1.1, 0.0, INF))


def test_beams_that_differ_are_brought_onto_the_grid() -> None:
    grid = BeamGrid(4, 0.0, math.tau / 4)
    turns = [
        replace(scan(1.0, 2.0, 3.0, 4.0, increment=math.tau / 4), angle_min=0.1),
        scan(4.2, 1.2, 2.2, 3.2, increment=math.tau / 4),
        replace(scan(2.4, 3.4, 4.4, increment=math.tau / 4), angle_min=math.tau / 4),
    ]
    middle = median_scan([turns[0], replace(turns[1], angle_min=-math.tau / 4), turns[2]], grid)
    assert middle.ranges == (1.0, 2.2, 3.2, 4.2)
    assert (middle.angle_min, middle.angle_increment) == (0.0, math.tau / 4)


def test_no_scan_has_no_median() -> None:
    with pytest.raises(ValueError, match="at least one"):
        median_scan([], GRID)
