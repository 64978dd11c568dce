"""The world's scans: errors of object, robot and lidar, drawn apart from the simulation of the ranking."""

import math
from dataclasses import replace

import numpy as np
import pytest

from voa_core.simulation import Sampling
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.scans import LOST_BEAMS, WorldScans, measured_ranges
from voa_evaluation.values.setting import ROBOT_ERRORS, SPREAD_XY_M, SPREAD_YAW_RAD, RobotError

MANY = Sampling("any", 400)


def test_noise_is_millimetres_close_by_and_a_share_beyond(bench: Bench) -> None:
    normal = np.random.default_rng(0).standard_normal((4000, 3))
    exact = np.tile([0.3, 0.45, 2.0], (4000, 1))
    ranges = measured_ranges(exact, normal, bench.scenario.lidar, None)
    assert ranges.std(axis=0) == pytest.approx([0.003, 0.003, 0.06], rel=0.05)
    assert ranges.mean(axis=0) == pytest.approx([0.3, 0.45, 2.0], abs=0.003)


def test_beams_are_classified_as_measured_ones(bench: Bench) -> None:
    exact = np.array([[0.01, 3.6, np.inf, 1.0]])
    ranges = measured_ranges(exact, np.zeros((1, 4)), bench.scenario.lidar, None)
    assert np.isnan(ranges[0, 0])
    assert ranges[0, 1] == ranges[0, 2] == np.inf
    assert ranges[0, 3] == 1.0


def test_a_share_of_the_beams_is_lost(bench: Bench) -> None:
    scans = bench.world.scans(bench.sensors[0], MANY, listed=True)[0]
    assert np.isnan(scans.ranges).mean() == pytest.approx(LOST_BEAMS, abs=0.012)


def displacements(world: WorldScans, bench: Bench, place: int, robot: int = 0) -> np.ndarray:
    return world._displacements(bench.sensors[place], 2000, robot)


def test_without_robot_error_all_places_see_one_displacement_of_the_stated_spread(bench: Bench) -> None:
    world = replace(bench.world, error=RobotError(0.0, 0.0))
    first, other = displacements(world, bench, 0), displacements(world, bench, 3)
    assert np.allclose(first, other, atol=1e-12)
    spread = first.reshape(-1, 3).std(axis=0)
    assert spread == pytest.approx([SPREAD_XY_M, SPREAD_XY_M, SPREAD_YAW_RAD], rel=0.05)


def test_a_robot_that_stands_to_the_left_sees_the_object_to_the_right(bench: Bench) -> None:
    """Brute force: the object's place in the frame of the lidar where it really stands."""
    world = replace(bench.world, error=ROBOT_ERRORS[2])
    sensor, positions = bench.sensors[2], bench.scenario.poses.positions
    assert positions is not None
    shape = len(positions), 5, 3
    own = world._random("object").standard_normal(shape) * [SPREAD_XY_M, SPREAD_XY_M, SPREAD_YAW_RAD]
    off = world._random("robot", sensor.name, 0).standard_normal(shape) * [0.03, 0.03, math.radians(2.0)]
    seen = world._displacements(sensor, 5, 0)
    for pose, sample in [(0, 0), (3, 4)]:
        heading = sensor.yaw_rad + off[pose, sample, 2]
        lidar = np.array([sensor.x, sensor.y]) + off[pose, sample, :2]
        really = _in_frame(positions[pose, :2] + own[pose, sample, :2], lidar, heading)
        believed = _in_frame(
            positions[pose, :2] + seen[pose, sample, :2], np.array([sensor.x, sensor.y]), sensor.yaw_rad
        )
        assert really == pytest.approx(believed, abs=1e-12)
        assert seen[pose, sample, 2] == pytest.approx(own[pose, sample, 2] - off[pose, sample, 2])


def _in_frame(point: np.ndarray, origin: np.ndarray, heading: float) -> np.ndarray:
    x, y = point - origin
    return np.array([math.cos(heading) * x + math.sin(heading) * y, math.cos(heading) * y - math.sin(heading) * x])


def test_scans_in_a_row_share_the_robots_error_unless_another_robot_takes_them(bench: Bench) -> None:
    assert np.array_equal(displacements(bench.world, bench, 1), displacements(bench.world, bench, 1))
    assert not np.allclose(displacements(bench.world, bench, 1), displacements(bench.world, bench, 1, robot=1))
    first, second = bench.world.scans(bench.sensors[1], Sampling("any", 4), listed=True, looks=2)
    assert not np.array_equal(first.ranges, second.ranges, equal_nan=True)
    both = np.isfinite(first.ranges) & np.isfinite(second.ranges)
    assert np.abs(first.ranges[both] - second.ranges[both]).max() < 0.03
    again = bench.world.scans(bench.sensors[1], Sampling("any", 4), listed=True, looks=2)[1]
    assert np.array_equal(second.ranges, again.ranges, equal_nan=True)
