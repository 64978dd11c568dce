"""Predictions on the window of beams that can meet the object, against the rasteriser of whole scans."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.voa_core.test_displaced_scans import GRIDS, OBJECTS, same_scans
from tests.voa_core.test_rasterising import one_segment
from tests.voa_core.worlds import lidar_of, standing
from voa_core.checks import Floats
from voa_core.cutting import Contours, cut_poses
from voa_core.geometry import quaternion_of_matrix, turn
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rasterising import rasterise
from voa_core.window_rasterising import ATAN_SINGLE, CLEAR, MARGIN_RAD, _turn_ahead, aim, bearing, rasterise_windows

FINE = BeamGrid(7200, 0.0, math.radians(0.05))
COARSE = BeamGrid(3, 0.3, 4.0)


def three_poses(rng: np.random.Generator) -> PoseSet:
    return PoseSet.from_arrays(
        ["A", "B", "C"],
        [(*rng.uniform(-0.03, 0.03, 2), 0.0) for _ in range(3)],
        [quaternion_of_matrix(turn(yaw)) for yaw in rng.uniform(-4.0, 4.0, 3)],
    )


def dense(contours: Contours, sensor: SensorConfiguration, grid: BeamGrid, range_max: float = 0.9) -> Floats:
    """Ranges (n, r) of every beam by windows; every pose must be seen from well outside."""
    columns, ranges, is_seen = rasterise_windows(contours, sensor, grid, range_max)
    assert is_seen.all()
    assert (np.diff(columns) > 0).all()
    assert (ranges < np.inf).any(axis=0).all(), "a column is kept on which nothing returns"
    whole: Floats = np.full((len(ranges), grid.beams), np.inf)
    whole[:, columns] = ranges
    return whole


def test_the_arc_tangent_is_the_chebyshev_interpolant_that_it_says() -> None:
    def ratio(u: Floats) -> Floats:
        root = np.sqrt(u)
        values: Floats = np.arctan(root) / root
        return values

    derived = np.polynomial.Chebyshev.interpolate(ratio, 6, domain=[0.0, 1.0])
    assert list(derived.convert(kind=np.polynomial.Polynomial).coef) == pytest.approx(list(ATAN_SINGLE), rel=1e-6)


def test_bearings_are_within_1e_6_of_atan2() -> None:
    for angle in np.linspace(-1.57, 1.57, 401):
        for radius in (1e-3, 1.0, 50.0):
            x, y = np.float32(radius * math.cos(angle)), np.float32(radius * math.sin(angle))
            assert bearing(y, x) == pytest.approx(math.atan2(y, x), abs=1e-6)


@pytest.mark.parametrize("share", [1.0 / CLEAR, 0.5, 0.05])
@pytest.mark.parametrize("seed", range(3))
def test_the_error_of_a_bearing_is_below_a_tenth_of_the_margin(share: float, seed: int) -> None:
    """The nearest and the farthest points of a cut of radius 0.1 m, seen from where it is `share` of the distance."""
    rng = np.random.default_rng(seed)
    around = np.concatenate([np.linspace(0.0, 2.0 * math.pi, 200), rng.uniform(0.0, 2.0 * math.pi, 200)])
    points = 0.1 * np.array([np.cos(around), np.sin(around)])
    near = points.astype(np.float32)
    yaw, toward = rng.uniform(-math.pi, math.pi, 2)
    c, s = math.cos(yaw), math.sin(yaw)
    x0, y0 = 0.1 / share * math.cos(toward), 0.1 / share * math.sin(toward)
    got = np.zeros(400, dtype=np.float32)
    ahead = np.zeros(6)
    _turn_ahead(np.array([c, -s, s, c, x0, y0]), np.array([x0, y0, 0.0, 0.0]), ahead)
    aim(near[0], near[1], ahead, np.float32(1.0), got)
    x, y = c * points[0] - s * points[1] + x0, s * points[0] + c * points[1] + y0
    exact = np.remainder(np.arctan2(y, x) - toward + math.pi, 2.0 * math.pi) - math.pi
    assert np.abs(got - exact).max() < 0.1 * MARGIN_RAD


@settings(max_examples=150, deadline=None)
@given(
    name=st.sampled_from(sorted(OBJECTS)),
    grid=st.sampled_from((*GRIDS, COARSE)),
    seed=st.integers(0, 10_000),
    away=st.sampled_from([0.19, 0.3, 1.0]),  # the largest cut and its place reach to 0.186 m
)
def test_a_window_holds_all_that_a_whole_scan_does(name: str, grid: BeamGrid, seed: int, away: float) -> None:
    rng = np.random.default_rng(seed)
    contours = cut_poses(OBJECTS[name], three_poses(rng), 0.07)
    around = rng.uniform(-math.pi, math.pi)
    sensor = SensorConfiguration("a", away * math.cos(around), away * math.sin(around), rng.uniform(-4, 4))
    same_scans(dense(contours, sensor, grid), rasterise(contours, sensor, grid, 0.9))


def test_beams_may_be_far_closer_than_the_points_of_the_contour() -> None:
    contours = cut_poses(OBJECTS["box"], three_poses(np.random.default_rng(1)), 0.07)
    sensor = SensorConfiguration("a", -0.2, 0.05, 0.3)
    ours = dense(contours, sensor, FINE)
    assert np.isfinite(ours).sum(axis=1).max() > 512, "too few to be decided in several goes"
    same_scans(ours, rasterise(contours, sensor, FINE, 0.9))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("degrees", "low", "high"), [(30.0, 0.3, 0.5), (182.0, 0.4, 0.9), (219.0, 0.55, 0.75)])
def test_a_segment_seen_edge_on_shows_its_near_end_or_nothing(
    degrees: float, low: float, high: float, sign: int
) -> None:
    direction = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    ends = [(low * direction[0], low * direction[1]), (high * direction[0], high * direction[1])]
    seen = dense(
        one_segment(*ends[::sign]), SensorConfiguration("a", 0, 0, 0), BeamGrid(360, 0.0, math.radians(1.0)), 3.0
    )[0]
    assert set(np.flatnonzero(np.isfinite(seen)).tolist()) <= {round(degrees)}
    assert seen[np.isfinite(seen)].tolist() == pytest.approx([low] * int(np.isfinite(seen).sum()))


def test_a_segment_that_points_at_the_sensor_but_for_rounding_shows_its_near_end() -> None:
    contours = one_segment((0.3, -1e-13), (0.5, 1e-13))
    assert dense(contours, SensorConfiguration("a", 0, 0, 0), lidar_of(4).grid)[0].tolist() == [0.3, *[math.inf] * 3]


def test_a_hit_beyond_range_max_is_none() -> None:
    contours = one_segment((0.5, -0.1), (0.5, 0.1))
    for range_max, expected in ((0.49, math.inf), (0.5, 0.5)):
        assert dense(contours, SensorConfiguration("a", 0, 0, 0), lidar_of(4).grid, range_max)[0, 0] == expected


def test_a_pose_without_a_cut_shows_nothing() -> None:
    contours = cut_poses(OBJECTS["box"], standing((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), 0.07)
    ranges = dense(contours, SensorConfiguration("a", -0.3, 0.02, 0.0), lidar_of(4).grid)
    assert ranges[:, 0].tolist() == [pytest.approx(0.3), math.inf]


def test_poses_that_are_too_near_are_flagged_and_a_prediction_has_them_all() -> None:
    poses = standing((0.0, 0.0, 0.0), (0.3, 0.0, 0.0))
    sensor, lidar = SensorConfiguration("a", 0.05, 0.02, 0.0), lidar_of(360)
    contours = cut_poses(OBJECTS["box"], poses, 0.1)
    columns, ranges, is_seen = rasterise_windows(contours, sensor, lidar.grid, 2.0)
    assert is_seen.tolist() == [False, True]
    assert np.isinf(ranges[0]).all()
    assert len(columns) == np.isfinite(ranges[1]).sum() > 5
    prediction = predictor_of_mesh(OBJECTS["box"], poses, lidar).predict(sensor).dense()
    same_scans(prediction, rasterise(contours, sensor, lidar.grid, 2.0))
    assert np.isfinite(prediction[0]).all()
