"""Raw scans from messages: the lidar supplies what a message omits, and beams that cannot be right are refused."""

import math
from typing import Any

import numpy as np
import pytest

from tests.support.scenarios import core_scenario
from voa_core.errors import BeamGridMismatch, InvalidInput
from voa_core.lidars import BeamGrid
from voa_core.scans import MISSING
from voa_msgs.sessions import Scan
from voa_service.mapping.scans import floats, scan_of

LIDAR = core_scenario().lidar


def scan(**fields: Any) -> Scan:
    return Scan.model_validate({"ranges": [0.5, None, 0.5, 0.5]} | fields)


def test_a_null_becomes_the_given_number() -> None:
    assert floats([0.5, None], math.inf) == [0.5, math.inf]


def test_a_scan_has_the_beams_of_the_lidar_unless_it_states_its_own() -> None:
    plain = scan_of(scan(no_return=[3]), LIDAR)
    np.testing.assert_array_equal(plain.ranges, [0.5, MISSING, 0.5, 0.5])
    assert (plain.grid, plain.no_return) == (LIDAR.grid, (3,))
    assert scan_of(scan(angle_min=1.0), LIDAR).grid == BeamGrid(4, 1.0, 0.1)
    other = scan_of(scan(ranges=[0.5] * 9, angle_min=-0.4, angle_increment=-0.05), LIDAR)
    assert other.grid == BeamGrid(9, -0.4, -0.05)


def test_another_number_of_beams_needs_both_angles() -> None:
    for angles in ({}, {"angle_min": 0.0}, {"angle_increment": 0.1}):
        with pytest.raises(BeamGridMismatch, match=r"\(4 from 0 rad by 0.1 rad\), got 5 ranges"):
            scan_of(scan(ranges=[0.5] * 5, **angles), LIDAR)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_beams_span_at_most_a_turn(sign: float) -> None:
    degree = sign * math.radians(1.0)
    own = {"angle_min": 0.0}
    scan_of(scan(ranges=[0.5] * 361, angle_increment=degree, **own), LIDAR)
    with pytest.raises(BeamGridMismatch, match=r"57\.3 turns: is it in degrees"):
        scan_of(scan(ranges=[0.5] * 360, angle_increment=sign, **own), LIDAR)


def test_range_limits_that_contradict_the_lidar_s_are_refused() -> None:
    own = scan_of(scan(range_min=0.2, range_max=0.3), LIDAR)
    assert own.limits(LIDAR) == (0.2, 0.3)
    with pytest.raises(InvalidInput, match="range_min: expected at most range_max"):
        scan_of(scan(range_min=2.5), LIDAR)
