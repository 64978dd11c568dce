import math
from typing import Any

import numpy as np
import pytest

from voa_core.errors import InvalidInput
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty

PLAIN: dict[str, Any] = {
    "grid": BeamGrid(4, 0.0, math.pi / 2),
    "range_min": 0.12,
    "range_max": 3.5,
    "height_m": 0.1,
    "zero": "missing",
    "noise_m": 0.01,
    "noise_ratio": 0.02,
    "dropout": 0.05,
}


def test_angles_start_at_angle_min_and_turn_by_the_increment() -> None:
    np.testing.assert_allclose(BeamGrid(3, 1.0, -0.5).angles, [1.0, 0.5, 0.0])


@pytest.mark.parametrize(
    ("beams", "start", "increment", "message"),
    [
        (0, 0.0, 0.1, "beams: expected at least 1, got 0"),
        (4, math.nan, 0.1, "angle_min: expected a finite number"),
        (4, 0.0, math.inf, "angle_increment: expected a finite number"),
        (4, 0.0, 0.0, "angle_increment: expected a number other than 0"),
        (4, 0.0, 1e300, "angle_increment: expected .* rad to a turn, to either side, got 1e[+]300"),
        (4, 0.0, -1e-300, "angle_increment: expected .* rad to a turn, to either side, got -1e-300"),
    ],
)
def test_a_grid_that_is_none_is_refused(beams: int, start: float, increment: float, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        BeamGrid(beams, start, increment)


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (BeamGrid(360, 2 * math.pi, math.radians(1)), True),
        (BeamGrid(360, 9e-5, math.radians(1)), True),
        (BeamGrid(360, -9e-5, math.radians(1)), True),
        (BeamGrid(360, 1.1e-4, math.radians(1)), False),
        (BeamGrid(360, 0.0, math.radians(1) + 1e-6), False),
        (BeamGrid(360, 0.0, -math.radians(1)), False),
        (BeamGrid(359, 0.0, math.radians(1)), False),
    ],
)
def test_grids_agree_when_no_beam_is_off_by_more_than_a_ten_thousandth(other: BeamGrid, same: bool) -> None:
    assert BeamGrid(360, 0.0, math.radians(1)).agrees_with(other) is same


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("range_min", -0.1, "range_min: expected a number of at least 0.0"),
        ("range_max", 0.12, "range_max: expected a number above 0.12"),
        ("range_max", math.inf, "range_max: expected a finite number"),
        ("height_m", math.nan, "height_m: expected a finite number"),
        ("zero", "nothing", "zero: expected 'missing' or 'no_return', got 'nothing'"),
        ("noise_m", 0.0, "noise_m: expected a number above 0.0"),
        ("noise_ratio", -0.1, "noise_ratio: expected a number of at least 0.0"),
        ("dropout", 1.0, "dropout: expected a number below 1.0"),
    ],
)
def test_a_lidar_that_cannot_be_is_refused(field: str, value: Any, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        LidarModel(**{**PLAIN, field: value})


def test_a_lidar_may_leave_its_height_to_the_sensor_configurations() -> None:
    assert LidarModel(**{**PLAIN, "height_m": None}).height_m is None


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x", math.nan, "x: expected a finite number"),
        ("y", math.inf, "y: expected a finite number"),
        ("yaw_rad", -math.inf, "yaw_rad: expected a finite number"),
        ("height_m", math.nan, "height_m: expected a finite number"),
        ("cost", -0.01, "cost: expected a number of at least 0.0"),
    ],
)
def test_a_sensor_configuration_that_cannot_be_is_refused(field: str, value: float, message: str) -> None:
    numbers: dict[str, Any] = {"x": 0.0, "y": 0.0, "yaw_rad": 0.0, field: value}
    with pytest.raises(InvalidInput, match=message):
        SensorConfiguration("Q1", **numbers)


@pytest.mark.parametrize(("xy_m", "yaw_rad", "field"), [(-1.0, 0.0, "xy_m"), (0.0, math.nan, "yaw_rad")])
def test_an_uncertainty_that_cannot_be_is_refused(xy_m: float, yaw_rad: float, field: str) -> None:
    with pytest.raises(InvalidInput, match=f"{field}: expected"):
        SensorUncertainty(xy_m, yaw_rad)
