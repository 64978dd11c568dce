"""Beams of a look as a recorded experiment holds them, classified as the service does."""

import math
from typing import Literal

import pytest

from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar
from voa_msgs.scenarios import Workspace
from voa_msgs.sessions import Scan
from voa_recordings.measured_beams import measured_beams
from voa_ros.grids import BeamGrid

GRID = BeamGrid(4, 0.0, math.pi / 2.0)
"""Beams to +x, +y, -x and -y."""
PLACE = SensorPose(x=0.0, y=0.0, yaw_rad=0.0)


def lidar(zero: Literal["missing", "no_return"] = "missing") -> Lidar:
    return Lidar(beams=4, angle_min=0.0, angle_increment=math.pi / 2.0, range_min=0.1, range_max=2.0, zero=zero)


def scan(*ranges: float | None, no_return: tuple[int, ...] = ()) -> Scan:
    return Scan(
        ranges=list(ranges), no_return=list(no_return), angle_min=0.0, angle_increment=math.pi / 2.0, range_min=0.1,
        range_max=2.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("value", "no_return", "zero", "kept", "missing"),
    [
        (0.5, (), "missing", 0.5, 0),
        (None, (), "missing", None, 1),
        (9.0, (0,), "missing", None, 0),
        (0.0, (), "missing", None, 1),
        (0.0, (), "no_return", None, 0),
        (0.05, (), "missing", None, 1),
        (2.5, (), "missing", None, 0),
    ],
)
def test_a_beam_is_a_return_a_no_return_or_missing(
    value: float | None,
    no_return: tuple[int, ...],
    zero: Literal["missing", "no_return"],
    kept: float | None,
    missing: int,
) -> None:
    beams = measured_beams(scan(value, 1.0, 1.0, 1.0, no_return=no_return), GRID, lidar(zero), PLACE, None)
    assert (list(beams.ranges), beams.missing) == ([kept, 1.0, 1.0, 1.0], missing)


def test_a_return_outside_of_the_workspace_is_not_the_objects() -> None:
    box = Workspace(min=[0.3, -0.1], max=[0.6, 0.1])
    beams = measured_beams(scan(0.4, 0.4, 0.4, 0.4), GRID, lidar(), PLACE, box)
    assert (list(beams.ranges), beams.missing) == ([0.4, None, None, None], 0)
    beams = measured_beams(scan(0.2, 0.4, 0.4, 0.4), GRID, lidar(), PLACE, box)  # in front: hidden
    assert (list(beams.ranges), beams.missing) == ([None] * 4, 1)
    beams = measured_beams(scan(0.7, 0.4, 0.4, 0.4), GRID, lidar(), PLACE, box)
    assert (list(beams.ranges), beams.missing) == ([None] * 4, 0)


def test_a_scan_on_another_grid_is_brought_onto_the_lidars() -> None:
    turned = Scan(ranges=[0.5, 0.6, 0.7, 0.8], angle_min=math.pi / 2.0, angle_increment=math.pi / 2.0)
    beams = measured_beams(turned, GRID, lidar(), PLACE, None)
    assert list(beams.ranges) == [0.8, 0.5, 0.6, 0.7]
