import math
import time

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from shapely.geometry import Point

from tests.support.twin import rotation_of
from tests.voa_core.worlds import BOX_FACES, box
from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.objects import Object
from voa_core.stable_poses import StablePose, propose_stable_poses


def object_of(mesh: trimesh.Trimesh) -> Object:
    return Object.from_arrays(mesh.vertices, mesh.faces)


def up_of(pose: StablePose) -> Floats:
    """The direction, in the object's frame, that points up."""
    up: Floats = rotation_of(pose.quaternion_wxyz)[2]
    return up


def mug(radius: float = 0.040, height: float = 0.095, wall: float = 0.004, base: float = 0.005) -> trimesh.Trimesh:
    """A cup with a handle on its +x side; lengths in metres."""
    profile = [[0, 0], [radius, 0], [radius, height], [radius - wall, height], [radius - wall, base], [0, base]]
    body = trimesh.creation.revolve(np.array(profile), sections=64)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 17)
    path = np.column_stack([radius - wall / 2 + 0.0315 * np.cos(turn), 0 * turn, 0.047 + 0.030 * np.sin(turn)])
    handle = trimesh.creation.sweep_polygon(Point(0, 0).buffer(0.0055, quad_segs=4), path)
    cavity = trimesh.creation.cylinder(radius=radius - wall, height=0.2)
    cavity.apply_translation([0, 0, 0.1 + base])
    whole = trimesh.boolean.union([body, handle], engine="manifold")
    cup: trimesh.Trimesh = trimesh.boolean.difference([whole, cavity], engine="manifold")
    return cup


def test_a_box_of_three_different_sides_rests_in_six_ways() -> None:
    poses = propose_stable_poses(box(0.1, 0.2, 0.3))
    assert len(poses) == 6
    assert sum(pose.probability for pose in poses) == pytest.approx(1.0, abs=1e-12)
    heights = [0.0 if up_of(pose).sum() > 0 else float(np.abs(up_of(pose)) @ [0.1, 0.2, 0.3]) for pose in poses]
    assert [pose.position[2] for pose in poses] == pytest.approx(heights, abs=1e-12)


def test_a_box_rests_most_often_on_its_largest_faces_and_opposite_ones_are_as_likely() -> None:
    poses = propose_stable_poses(box(0.1, 0.2, 0.3))
    resting_on = [int(np.abs(up_of(pose)).argmax()) for pose in poses]
    assert resting_on == [0, 0, 1, 1, 2, 2]
    probabilities = [pose.probability for pose in poses]
    assert probabilities == sorted(probabilities, reverse=True)
    assert probabilities[::2] == pytest.approx(probabilities[1::2], rel=1e-6)


def test_a_cube_rests_on_each_face_alike() -> None:
    poses = propose_stable_poses(box(0.1, 0.1, 0.1))
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6, abs=1e-9)


@pytest.mark.parametrize("sections", [24, 32, 64])
def test_the_round_side_of_a_cylinder_is_one_way_to_rest(sections: int) -> None:
    poses = propose_stable_poses(object_of(trimesh.creation.cylinder(radius=0.03, height=0.1, sections=sections)))
    assert [abs(round(float(up_of(pose)[2]), 6)) for pose in poses] == [0.0, 1.0, 1.0]
    assert poses[0].probability > 0.8
    assert sum(pose.probability for pose in poses) == pytest.approx(1.0, abs=1e-12)


def test_a_ball_has_one_way_to_rest() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    (anyhow,) = propose_stable_poses(object_of(ball))
    assert anyhow.probability == pytest.approx(1.0)
    assert anyhow.position[2] == pytest.approx(0.05, rel=0.03)


def test_the_sides_of_a_pencil_are_six() -> None:
    pencil = trimesh.creation.cylinder(radius=0.03, height=0.1, sections=6)
    assert len(propose_stable_poses(object_of(pencil))) == 8


def test_a_mug_stands_lies_on_its_rim_or_leans_on_its_handle_to_either_side() -> None:
    poses = propose_stable_poses(object_of(mug()))
    assert len(poses) == 4
    left, right, upright, upside_down = poses
    for lying, side in ((left, -1.0), (right, 1.0)):
        up = up_of(lying) if up_of(left)[1] < 0 else up_of(lying) * [1.0, -1.0, 1.0]
        # The handle points 30 degrees below the horizontal; 2 degrees are left for the facets.
        assert math.degrees(math.asin(up[0])) == pytest.approx(-30.0, abs=2.0)
        assert up[1] * side > 0.8
        assert lying.probability == pytest.approx(0.376, abs=0.01)
    np.testing.assert_allclose(up_of(upright), [0.0, 0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(up_of(upside_down), [0.0, 0.0, -1.0], atol=1e-6)
    assert upright.probability == pytest.approx(0.153, abs=0.01)
    assert sum(pose.probability for pose in poses) == pytest.approx(1.0, abs=1e-12)


def test_an_object_rests_on_the_table_below_its_centre_of_mass() -> None:
    mesh = mug()
    for pose in propose_stable_poses(object_of(mesh)):
        placed = mesh.vertices @ rotation_of(pose.quaternion_wxyz).T + pose.position
        assert placed[:, 2].min() == pytest.approx(0.0, abs=1e-6)
        centre = rotation_of(pose.quaternion_wxyz) @ mesh.center_mass + pose.position
        np.testing.assert_allclose(centre[:2], 0.0, atol=1e-9)


def test_proposals_are_the_same_every_time() -> None:
    assert propose_stable_poses(box(0.1, 0.2, 0.3)) == propose_stable_poses(box(0.1, 0.2, 0.3))


def test_a_mesh_with_a_hole_rests_as_its_hull() -> None:
    open_box = Object.from_arrays(box(0.1, 0.2, 0.3).vertices, BOX_FACES[2:])
    assert not open_box.watertight
    assert len(propose_stable_poses(open_box)) == 6


def test_a_thin_sheet_rests_on_either_side() -> None:
    assert len(propose_stable_poses(box(0.1, 0.2, 1e-6))) == 2


@pytest.mark.parametrize("thickness", [1e-9, 1e-12, 1e-15])
def test_a_sheet_of_next_to_no_thickness_has_no_way_to_rest(thickness: float) -> None:
    with pytest.raises(InvalidInput, match="object: expected a mesh with a volume"):
        propose_stable_poses(box(0.1, 0.2, thickness))


def same(actual: list[StablePose], expected: list[StablePose]) -> None:
    """Both lie in the same ways, and as often."""
    by_direction = [sorted(poses, key=lambda pose: up_of(pose).round(6).tolist()) for poses in (actual, expected)]
    for pose, other in zip(*by_direction, strict=True):
        np.testing.assert_allclose(up_of(pose), up_of(other), atol=1e-9)
        assert pose.position == pytest.approx(other.position, abs=1e-9)
        assert pose.probability == pytest.approx(other.probability, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_flipped_faces_change_nothing_where_the_mesh_is_watertight(seed: int) -> None:
    mesh = mug()
    faces: NDArray[np.int64] = np.array(mesh.faces)
    flipped = np.random.default_rng(seed).uniform(size=len(faces)) < 0.3
    faces[flipped] = faces[flipped, ::-1]
    same(propose_stable_poses(Object.from_arrays(mesh.vertices, faces)), propose_stable_poses(object_of(mesh)))


def test_a_mesh_with_a_hole_and_flipped_faces_rests_as_its_hull() -> None:
    mesh = mug()
    faces: NDArray[np.int64] = np.array(mesh.faces)[:-1]
    faces[::3] = faces[::3, ::-1]
    same(
        propose_stable_poses(Object.from_arrays(mesh.vertices, faces)),
        propose_stable_poses(object_of(mesh.convex_hull)),
    )


def test_a_can_stands_however_improbable_that_is_and_a_pencil_does_not() -> None:
    for diameter, rests in ((0.041, 3), (0.0325, 3), (0.0305, 1)):  # 11.6, 9.2 and 8.7 degrees
        can = trimesh.creation.cylinder(radius=0.5 * diameter, height=0.2, sections=64)
        assert len(propose_stable_poses(object_of(can))) == rests


@pytest.mark.parametrize("width", [0.002, 0.008, 0.02])
def test_a_square_rod_rests_on_its_four_sides(width: float) -> None:
    poses = propose_stable_poses(box(width, width, 0.2))
    assert [pose.probability for pose in poses] == pytest.approx([0.25] * 4, abs=2e-3)


@pytest.mark.parametrize("far", [[5e5, 0.0, 0.0], [0.0, 5.4e6, 0.0], [5e5, -5.4e6, 120.0], [1e7, 1e7, 1e7]])
def test_an_object_far_from_its_origin_rests_as_near_it(far: list[float]) -> None:
    near, moved = mug(), mug()
    moved.apply_translation(far)
    expected, proposed = propose_stable_poses(object_of(near)), propose_stable_poses(object_of(moved))
    assert len(proposed) == len(expected)
    for pose, other in zip(proposed, expected, strict=True):
        assert pose.probability == pytest.approx(other.probability, abs=1e-6)
        placed = moved.vertices @ rotation_of(pose.quaternion_wxyz).T + pose.position
        assert placed[:, 2].min() == pytest.approx(0.0, abs=1e-7)
        assert np.abs(placed).max() < 0.2


def test_vertices_that_no_face_uses_hold_nothing_up() -> None:
    stray = np.concatenate([box(0.1, 0.2, 0.3).vertices, [[0.05, 0.1, -1.0], [7.0, 7.0, 7.0]]])
    with_them = Object(stray, box(0.1, 0.2, 0.3).faces)
    same(propose_stable_poses(with_them), propose_stable_poses(box(0.1, 0.2, 0.3)))


def test_a_fine_ball_takes_a_fifth_of_two_seconds_at_most() -> None:
    ball = object_of(trimesh.creation.icosphere(subdivisions=4, radius=0.1))
    assert len(ball.faces) == 5120
    began = time.process_time()
    (anyhow,) = propose_stable_poses(ball)
    assert time.process_time() - began < 0.2 * 2.0
    assert anyhow.probability == pytest.approx(1.0)


def test_a_hull_of_too_many_triangles_is_refused() -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(25_100, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = np.arange(25_098).reshape(-1, 3)
    with pytest.raises(InvalidInput, match=r"at most 50000 triangles in its convex hull, .* got 50192: simplify it"):
        propose_stable_poses(Object.from_arrays(points, faces))


def test_countless_points_are_refused_before_anything_is_computed() -> None:
    points = np.random.default_rng(1).normal(size=(200_100, 3))
    with pytest.raises(InvalidInput, match="at most 200000 points"):
        propose_stable_poses(Object.from_arrays(points, np.arange(200_100).reshape(-1, 3)))


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        ([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        ([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]]),
        ([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]),
    ],
)
def test_a_flat_mesh_has_no_way_to_rest(vertices: list[list[float]], faces: list[list[int]]) -> None:
    with pytest.raises(InvalidInput, match="object: expected a mesh with a volume, got one without a convex hull"):
        propose_stable_poses(Object.from_arrays(vertices, faces))
