"""Headers of scans that contradict themselves, and those that only look odd."""

import math
from dataclasses import replace

import pytest
from hypothesis import given

from tests.voa_ros.ros_messages import scan, scans
from voa_ros.cdr import decode_laser_scan, encode_laser_scan
from voa_ros.grids import upside_down
from voa_ros.messages import LaserScan, header_contradiction

DEGREE = math.radians(1.0)


def header(low: float, high: float, increment: float, beams: int) -> LaserScan:
    return replace(scan(*[1.0] * beams), angle_min=low, angle_max=high, angle_increment=increment)


@pytest.mark.parametrize(
    ("low", "high", "increment", "beams"),
    [
        (0.0, 6.28, DEGREE, 360),  # LDS-01
        (0.0, math.tau, math.tau / 459, 460),  # LDS-02: both ends
        (0.0, math.tau, math.tau / 455, 457),  # a beam more than its driver meant
        (0.0, math.tau, math.tau / 450, 470),  # a motor that is slow
        (0.0, math.tau, 0.7, 10),  # a coarse one
        (-math.pi, math.pi, math.tau / 719, 720),  # RPLIDAR
        (math.pi, -math.pi, -math.tau / 719, 720),  # clockwise, and says so
        (-2.35, 2.35, 0.00436, 1_081),  # Hokuyo
        (0.0, 0.0, DEGREE, 360),  # angle_max was never set
        (0.0, 0.0, -DEGREE, 360),
        (1.0, 1.0, DEGREE, 1),
        (0.0, math.nan, DEGREE, 360),
        (0.0, 1e-7, -DEGREE, 2),  # float32's noise
    ],
)
def test_headers_of_drivers_pass(low: float, high: float, increment: float, beams: int) -> None:
    measured = header(low, high, increment, beams)
    for sent in (measured, upside_down(measured), decode_laser_scan(encode_laser_scan(measured))):
        assert header_contradiction(sent) is None


@pytest.mark.parametrize(
    ("low", "high", "increment", "says"),
    [
        (-3.14159, 3.12414, -0.0174533, "say that the angles grow, angle_increment -0.0174533 says that they fall"),
        (3.14159, -3.12414, 0.0174533, "say that the angles fall, angle_increment 0.0174533 says that they grow"),
    ],
)
def test_angles_that_run_both_ways_are_reported_with_all_numbers(
    low: float, high: float, increment: float, says: str
) -> None:
    wrong = header_contradiction(header(low, high, increment, 360))
    assert wrong is not None
    assert wrong.startswith(f"angle_min {low} and angle_max {high} {says}")
    assert "reversed" in wrong


@pytest.mark.parametrize(
    ("increment", "turns"), [(1.0, "57.3"), (-1.0, "57.3"), (math.radians(2.0), "2"), (math.radians(1.06), "1.06")]
)
def test_more_than_a_turn_is_reported_in_turns(increment: float, turns: str) -> None:
    wrong = header_contradiction(header(0.0, 359 * increment, increment, 360))
    assert wrong == (
        f"360 beams of angle_increment {increment:.6g} rad are {turns} turns: expected at most one turn, with angles "
        "in radians"
    )


@given(scans())
def test_any_scan_has_a_contradiction_or_none(measured: LaserScan) -> None:
    wrong = header_contradiction(measured)
    assert wrong is None or "expected" in wrong or "wrong" in wrong
