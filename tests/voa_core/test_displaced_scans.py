"""Predictions of displaced copies on the beams that can meet them, against those of poses that lie there."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.voa_core.worlds import box, lidar_of, standing
from voa_core.checks import Floats
from voa_core.cutting import Contours, cut_poses
from voa_core.displaced_scans import DisplacedScans, joined_scans, predict_copies, predict_displaced_scans
from voa_core.displacements import displaced
from voa_core.geometry import quaternion_of_matrix, turn
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.objects import Object
from voa_core.outlines import outlines_of
from voa_core.poses import PoseSet
from voa_core.prediction import Prediction, predictor_of_mesh
from voa_core.rasterising import rasterise
from voa_core.workspace import Workspace

FULL = BeamGrid(360, 0.0, math.radians(1.0))
GRIDS = (
    FULL,
    BeamGrid(360, 1.0, -math.radians(1.0)),
    BeamGrid(500, -9.0, math.radians(0.5)),
    BeamGrid(270, -2.0, math.radians(1.0)),
    BeamGrid(13, 0.3, 2.0 * math.pi / 13),
    BeamGrid(400, 0.0, math.radians(1.0)),
    BeamGrid(5, 0.0, 1.2),
)


def prisms(*outlines: list[tuple[float, float]], height: float = 0.2, cap: bool = True) -> Object:
    """Upright prisms over star-shaped polygons, counter-clockwise; without caps they lack a wall."""
    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []
    for outline in outlines:
        first, n = len(vertices), len(outline)
        vertices += [(x, y, z) for z in (0.0, height) for x, y in outline]
        centre = np.mean(outline, axis=0)
        vertices += [(float(centre[0]), float(centre[1]), z) for z in (0.0, height)]
        for i in range(n if cap else n - 1):
            a, b = first + i, first + (i + 1) % n
            faces += [(a, b, b + n), (a, b + n, a + n)]
            if cap:
                faces += [(b, a, first + 2 * n), (a + n, b + n, first + 2 * n + 1)]
    return Object.from_arrays(vertices, faces)


def ring(corners: int, radius: float, x: float = 0.0, y: float = 0.0, wave: float = 0.0) -> list[tuple[float, float]]:
    angles = [2.0 * math.pi * i / corners for i in range(corners)]
    radii = [radius * (1.0 + wave * math.cos(3.0 * angle)) for angle in angles]
    return [(x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]


OBJECTS = {
    "box": box(0.12, 0.05, 0.2),
    "wavy": prisms(ring(40, 0.06, wave=0.4)),
    "one inside another": prisms(ring(12, 0.06), ring(9, 0.03)),
    "two that cross": prisms(ring(12, 0.05), ring(9, 0.05, 0.04)),
    "two apart": prisms(ring(7, 0.02, -0.04), ring(9, 0.03, 0.05, 0.01)),
    "open": prisms(ring(8, 0.05)[:5], cap=False),
    "pentagram": prisms([ring(5, 0.06)[i] for i in (0, 2, 4, 1, 3)]),
}


def same_scans(own: Floats, expected: Floats) -> None:
    """Every range agrees, but for beams that meet an edge of the silhouette to rounding."""
    both = np.isfinite(own) & np.isfinite(expected)
    assert np.array_equal(np.isfinite(own), np.isfinite(expected))
    np.testing.assert_allclose(own[both], expected[both], rtol=0, atol=1e-8)


@settings(max_examples=150, deadline=None)
@given(
    name=st.sampled_from(sorted(OBJECTS)),
    grid=st.sampled_from(GRIDS),
    seed=st.integers(0, 10_000),
    away=st.sampled_from([0.0, 0.03, 0.11, 0.3, 1.0]),
    spread=st.sampled_from([0.003, 0.03]),
)
def test_copies_are_seen_as_poses_that_lie_there(
    name: str, grid: BeamGrid, seed: int, away: float, spread: float
) -> None:
    rng = np.random.default_rng(seed)
    poses = PoseSet.from_arrays(
        ["A", "B", "C"],
        [(*rng.uniform(-0.03, 0.03, 2), 0.0) for _ in range(3)],
        [quaternion_of_matrix(turn(yaw)) for yaw in rng.uniform(-4.0, 4.0, 3)],
    )
    contours = cut_poses(OBJECTS[name], poses, 0.07)
    around = rng.uniform(-math.pi, math.pi)
    sensor = SensorConfiguration("a", away * math.cos(around), away * math.sin(around), rng.uniform(-4, 4))
    displacements = rng.normal(0.0, 1.0, (2, 8, 3)) * [spread, spread, 5.0 * spread]
    own = predict_displaced_scans(contours, displacements, sensor, grid, 0.9, first=1)
    expected = rasterise(displaced(contours, displacements, 1), sensor, grid, 0.9)
    same_scans(own.prediction().dense(), expected)
    assert len(own) == 2
    assert own.copies == 8
    assert (own.ranges < np.inf).any(axis=1).all()
    one = own.prediction(1, 2).dense()
    same_scans(one, expected[8:])


def test_an_edge_that_points_at_the_lidar_shows_its_nearer_end() -> None:
    """The ends lie on one beam but for rounding, which would decide where the beam meets the edge."""
    wall = np.array([[0.0, -1e-13], [0.2, 1e-13]])
    whole = Contours(
        wall,
        np.array([[0, 1]], dtype=np.int32),
        np.array([0, 2]),
        np.array([0, 1]),
        np.array([0]),
        np.array([[1.0, 0.0, 0.3, 0.0]]),
    )
    sensor = SensorConfiguration("a", 0.0, 0.0, 0.0)
    scans = predict_displaced_scans(whole, np.zeros((1, 4, 3)), sensor, BeamGrid(180, 0.0, math.radians(1.0)), 2.0)
    assert scans.beams.tolist() == [0]
    assert scans.ranges.tolist() == [[0.3] * 4]


def test_only_edges_that_may_be_seen_are_left() -> None:
    contours = cut_poses(OBJECTS["one inside another"], standing((0.0, 0.0, 0.0)), 0.07)
    outlines = outlines_of(contours.points, contours.segments, contours.point_start, contours.segment_start)
    assert len(outlines.edges) == 12
    assert outlines.reach == pytest.approx([0.06])
    for name, edges in (("two apart", 16), ("two that cross", 21), ("box", 4), ("pentagram", 10)):
        outlines = cut_poses(OBJECTS[name], standing((0.0, 0.0, 0.0)), 0.07).outlines
        assert len(outlines.edges) == edges, name
    cut = cut_poses(OBJECTS["open"], standing((0.0, 0.0, 0.0)), 0.07)
    assert len(cut.outlines.edges) == 2 * len(cut.segments)
    nothing = cut_poses(OBJECTS["box"], standing((0.0, 0.0, 0.0)), 0.7).outlines
    assert len(nothing.edges) == 0


def test_contours_that_fold_back_are_seen_from_both_sides() -> None:
    points = np.array([[0.0, 0.0], [0.2, 0.0], [0.1, 0.0], [0.1, 0.1]])
    segments = np.array([[0, 1], [1, 2], [2, 3], [3, 0]], dtype=np.int32)
    outlines = outlines_of(points, segments, np.array([0, 4]), np.array([0, 4]))
    assert len(outlines.edges) == 8
    spur = np.array([[0, 1], [0, 2], [0, 3]], dtype=np.int32)
    assert len(outlines_of(points, spur, np.array([0, 4]), np.array([0, 3])).edges) == 6


def test_limits_and_counts_of_returns() -> None:
    ranges = np.array([[0.3, np.inf, 0.5], [0.4, 0.6, np.inf], [np.inf, np.inf, np.inf], [0.7, 0.2, 0.9]])
    prediction = Prediction(BeamGrid(4, 0.0, 0.5), np.array([0, 1, 3]), ranges)
    scans = DisplacedScans.of(prediction, 2)
    np.testing.assert_array_equal(scans.prediction().dense(), prediction.dense())
    np.testing.assert_array_equal(scans.farthest, [0.4, 0.6, 0.5, 0.7, 0.2, 0.9])
    nothing = np.zeros(4, dtype=bool)
    assert scans.fewest_returns(nothing).tolist() == [2, 0]
    assert scans.fewest_returns(np.array([True, False, False, True])).tolist() == [0, 0]
    near = scans.restricted(0.5, None)
    np.testing.assert_array_equal(
        near.prediction().dense(), np.where(prediction.dense() <= 0.5, prediction.dense(), np.inf)
    )
    assert near.farthest[1] == -np.inf
    within = Workspace((-1.0, -1.0), (0.35, 1.0)).crossing(
        SensorConfiguration("a", 0.0, 0.0, 0.0), prediction.grid.angles
    )
    kept = scans.restricted(2.0, within).prediction().dense()
    assert kept[0, 0] == 0.3
    assert kept[1, 0] == np.inf
    twice = joined_scans([scans, scans])
    assert twice.start.tolist() == [0, 3, 6, 9, 12]
    assert twice.nbytes > scans.nbytes > 0


def test_scans_are_predicted_on_other_beams_too() -> None:
    predictor = predictor_of_mesh(OBJECTS["box"], standing((0.0, 0.0, 0.0)), lidar_of(72))
    sensor, displacements = SensorConfiguration("a", -0.4, 0.0, 0.0), np.full((1, 4, 3), 0.01)
    assert predict_copies(predictor, sensor, displacements).grid == predictor.lidar.grid
    assert predict_copies(predictor, sensor, displacements, FULL).grid == FULL
