import math

import numpy as np
import pytest

from tests.voa_core.worlds import UPRIGHT, box, standing
from voa_core.checks import Floats
from voa_core.cutting import Contours, cut_poses
from voa_core.errors import NoMesh
from voa_core.objects import Object
from voa_core.poses import PoseSet

CUBE = box(0.2, 0.2, 0.2)


def outline(contours: Contours, pose: int = 0) -> Floats:
    """Ends of the segments in the world, (g, 2, 2)."""
    cut = contours.cut_of_pose[pose]
    points = contours.points[contours.point_start[cut] : contours.point_start[cut + 1]]
    segments = contours.segments[contours.segment_start[cut] : contours.segment_start[cut + 1]]
    c, s, x, y = contours.placement[pose]
    world: Floats = points[segments] @ np.array([[c, s], [-s, c]]) + [x, y]
    return world


def length(contours: Contours, pose: int = 0) -> float:
    ends = outline(contours, pose)
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def test_a_cut_through_a_cube_is_its_square() -> None:
    contours = cut_poses(CUBE, standing((0.3, -0.1, 0.0)), 0.07)
    ends = outline(contours).reshape(-1, 2)
    assert length(contours) == pytest.approx(0.8)
    np.testing.assert_allclose([ends.min(axis=0), ends.max(axis=0)], [[0.3, -0.1], [0.5, 0.1]], atol=1e-12)


def test_contours_are_closed_and_neighbours_share_their_points() -> None:
    contours = cut_poses(CUBE, standing((0.0, 0.0, 0.0)), 0.07)
    assert (np.bincount(contours.segments.reshape(-1)) == 2).all()


@pytest.mark.parametrize("height", [-0.01, 0.21, 5.0])
def test_a_plane_that_misses_the_object_cuts_nothing(height: float) -> None:
    contours = cut_poses(CUBE, standing((0.0, 0.0, 0.0)), height)
    assert len(contours.segments) == 0
    assert contours.points.shape == (0, 2)


@pytest.mark.parametrize("height", [0.0, 0.2, 1e-12, 0.2 - 1e-12, 0.2 + 1e-12])
def test_a_plane_in_the_top_or_bottom_face_touches_the_object_all_around(height: float) -> None:
    contours = cut_poses(CUBE, standing((0.0, 0.0, 0.0)), height)
    ends = outline(contours).reshape(-1, 2)
    np.testing.assert_allclose([ends.min(axis=0), ends.max(axis=0)], [[0.0, 0.0], [0.2, 0.2]], atol=1e-9)
    assert length(contours) == pytest.approx(0.8)


def test_a_plane_through_a_ring_of_vertices_cuts_below_and_above_it() -> None:
    # Two square pyramids base to base: the ring at z = 0 is the widest cut, seen from both sides of the plane.
    ring = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, -0.1, 0.0]]
    faces = [[i, (i + 1) % 4, 4] for i in range(4)] + [[(i + 1) % 4, i, 5] for i in range(4)]
    contours = cut_poses(Object.from_arrays([*ring, [0, 0, 0.1], [0, 0, -0.1]], faces), standing((0.0, 0.0, 0.0)), 0.0)
    assert length(contours) == pytest.approx(2 * 4 * 0.1 * math.sqrt(2.0))
    np.testing.assert_allclose(np.abs(outline(contours)).sum(axis=2), 0.1)


def test_a_plane_through_one_tip_touches_a_point() -> None:
    tip = [[0.0, 0.0, 0.1], [0.1, 0.0, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0]]
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    contours = cut_poses(Object.from_arrays(tip, faces), standing((0.0, 0.0, 0.0)), 0.1)
    np.testing.assert_allclose(outline(contours), 0.0, atol=1e-12)
    assert length(contours) == pytest.approx(0.0, abs=1e-12)


def test_a_plane_along_an_edge_touches_the_edge() -> None:
    # A tent: its ridge runs along x at z = 0.1.
    tent = [[0, -0.1, 0], [0.3, -0.1, 0], [0.3, 0.1, 0], [0, 0.1, 0], [0, 0, 0.1], [0.3, 0, 0.1]]
    faces = [[0, 1, 5], [0, 5, 4], [2, 3, 4], [2, 4, 5], [0, 4, 3], [1, 2, 5], [0, 3, 2], [0, 2, 1]]
    ends = outline(cut_poses(Object.from_arrays(tent, faces), standing((0.0, 0.0, 0.0)), 0.1)).reshape(-1, 2)
    np.testing.assert_allclose(ends[:, 1], 0.0, atol=1e-12)
    assert (ends[:, 0].min(), ends[:, 0].max()) == (pytest.approx(0.0), pytest.approx(0.3))


def test_poses_that_differ_by_a_planar_motion_share_a_cut() -> None:
    half = math.sqrt(0.5)
    poses = PoseSet.from_arrays(
        ["as is", "moved", "turned", "lifted", "tilted"],
        np.array([(0, 0, 0), (0.4, 0.1, 0), (0, 0, 0), (0, 0, 0.01), (0, 0, 0)]),
        np.array([UPRIGHT, UPRIGHT, (half, 0, 0, half), UPRIGHT, (half, half, 0, 0)]),
    )
    cut_of = cut_poses(box(0.1, 0.2, 0.3), poses, 0.05).cut_of_pose
    assert len(set(cut_of.tolist())) == 3
    assert cut_of[0] == cut_of[1] == cut_of[2]
    assert len({int(cut_of[0]), int(cut_of[3]), int(cut_of[4])}) == 3


def test_a_shared_cut_is_put_where_each_pose_is() -> None:
    half = math.sqrt(0.5)
    poses = PoseSet.from_arrays(
        ["A", "B"], np.array([(0, 0, 0), (0.5, 0.1, 0)]), np.array([UPRIGHT, (half, 0, 0, half)])
    )
    contours = cut_poses(box(0.1, 0.2, 0.3), poses, 0.05)
    for pose, (low, high) in enumerate([((0.0, 0.0), (0.1, 0.2)), ((0.3, 0.1), (0.5, 0.2))]):
        ends = outline(contours, pose).reshape(-1, 2)
        np.testing.assert_allclose(np.array([ends.min(axis=0), ends.max(axis=0)]), np.array([low, high]), atol=1e-12)


def test_a_triangle_with_two_equal_corners_is_no_face() -> None:
    flat = Object.from_arrays(np.array([[0.0, 0, 0], [0.1, 0, 0.2], [0, 0.1, 0.2]]), [[0, 0, 1], [0, 1, 2]])
    assert length(cut_poses(flat, standing((0.0, 0.0, 0.0)), 0.1)) == pytest.approx(0.05 * math.sqrt(2.0))


def test_a_contour_may_have_any_number_of_segments() -> None:
    turns = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    ring = np.column_stack([0.1 * np.cos(turns), 0.1 * np.sin(turns)])
    corners = np.concatenate([np.column_stack([ring, np.full(200, z)]) for z in (0.0, 0.2)])
    faces = [[i, (i + 1) % 200, 200 + i] for i in range(200)] + [
        [(i + 1) % 200, 200 + (i + 1) % 200, 200 + i] for i in range(200)
    ]
    contours = cut_poses(Object.from_arrays(corners, faces), standing((0.0, 0.0, 0.0), (0.0, 0.0, 0.05)), 0.1)
    for pose in range(2):
        assert length(contours, pose) == pytest.approx(200 * 0.2 * math.sin(math.pi / 200))


def test_memory_is_counted() -> None:
    small = cut_poses(CUBE, standing((0.0, 0.0, 0.0)), 0.07)
    own = sum(a.nbytes for a in (small.points, small.segments, small.placement, small.cut_of_pose))
    assert own + small.outlines.nbytes <= small.nbytes <= 4 * own


def test_poses_without_geometry_cannot_be_cut() -> None:
    with pytest.raises(NoMesh, match="the poses have names only"):
        cut_poses(CUBE, PoseSet.named(["A"]), 0.1)
