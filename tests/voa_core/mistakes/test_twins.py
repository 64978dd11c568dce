"""Twins are found by what the meshes cover, not by how they are cut into faces."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.voa_core.mistakes.table import mistakes_of_table, poses_at, wedge
from tests.voa_core.worlds import box
from voa_core.grasps import GraspTable
from voa_core.mistakes.effort import QUICK, THOROUGH, Effort
from voa_core.mistakes.surface import Surface, _square_distance
from voa_core.mistakes.twins import mistakes_of_twins
from voa_core.objects import Object
from voa_core.poses import PoseSet


def cylinder(sides: int, radius: float = 0.03, height: float = 0.1) -> Object:
    angles = 2.0 * math.pi * np.arange(sides) / sides
    ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    vertices = [(x, y, z) for z in (0.0, height) for x, y in ring] + [(0.0, 0.0, 0.0), (0.0, 0.0, height)]
    bottom, top = 2 * sides, 2 * sides + 1
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [[i, j, sides + j], [i, sides + j, sides + i], [j, i, bottom], [sides + i, sides + j, top]]
    return Object.from_arrays(vertices, faces)


def groups(
    object_: Object, poses: PoseSet, effort: Effort = THOROUGH, scores: list[float] | None = None
) -> list[tuple[str, ...]]:
    table = GraspTable.of_probabilities(["G"], [scores or [0.5] * len(poses)], len(poses))
    return [mistake.poses for mistake in mistakes_of_twins(poses, table, object_, effort)]


def test_a_can_that_is_turned_about_its_axis_stays_where_it_is() -> None:
    # 64 sides of 30 mm: a turn by less than a side moves the wall by up to 0.036 mm, its corners by up to 1.5 mm.
    poses = poses_at((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 90.0), (0.0, 0.01, 0.0, 0.0))
    assert groups(cylinder(64), poses) == [("P0", "P1", "P2")]
    # 12 sides: by up to 1 mm.
    assert groups(cylinder(12), poses) == [("P0", "P2")]


def test_a_box_has_a_twin_half_a_turn_away() -> None:
    low = Object.from_arrays(box(0.1, 0.05, 0.02).vertices - [0.05, 0.025, 0.0], box(0.1, 0.05, 0.02).faces)
    poses = poses_at(*((0.0, 0.0, 0.0, 45.0 * i) for i in range(8)))
    assert groups(low, poses) == [(f"P{i}", f"P{i + 4}") for i in range(4)]


def test_poses_without_geometry_have_no_twins() -> None:
    assert groups(wedge(), PoseSet.named(["A", "B"])) == []


def test_a_mirror_image_has_the_same_moments_and_is_no_twin() -> None:
    """Two prongs of equal moments, one bent left, one right: only the surface distinguishes them."""
    flat = Object.from_arrays(
        [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0], [0.2, 0.1, 0.5], [0.2, -0.1, -0.5]],
        [[0, 2, 4], [1, 2, 4], [0, 3, 5], [1, 3, 5], [0, 2, 5], [1, 3, 4]],
    )
    assert groups(flat, poses_at((0, 0, 0, 0), (0, 0, 0, 180.0), (0, 0, 0, 0.0))) == [("P0", "P2")]


def test_where_the_cost_is_bounded_only_so_many_are_compared() -> None:
    poses = poses_at(*((0.0, 0.0, 0.0, 0.0) for _ in range(30)))
    assert [len(group) for group in groups(wedge(), poses)] == [30]
    looked_at, compared = 50 * 30, 2 * Surface(wedge()).cost
    few = replace(QUICK, boxes=looked_at + 10 * compared)
    assert [len(group) for group in groups(wedge(), poses, few)] == [12]
    assert groups(wedge(), poses, replace(QUICK, boxes=0)) == []


def test_poses_that_grasp_differently_are_not_even_compared() -> None:
    poses = poses_at(*((0.0, 0.0, 0.0, 0.0) for _ in range(30)))
    scores = [0.01 * i for i in range(29)] + [0.28]
    few = replace(QUICK, boxes=50 * 2 + 2 * Surface(wedge()).cost)
    assert groups(wedge(), poses, few, scores) == [("P28", "P29")]


def test_only_the_first_groups_are_listed() -> None:
    poses = poses_at(*((0.1 * (i // 2), 0.0, 0.0, 0.0) for i in range(60)))
    assert len(groups(wedge(), poses)) == 20


def test_the_warning_names_the_poses() -> None:
    assert "poses 'P0', 'P1'" in mistakes_of_table(poses=poses_at((0, 0, 0, 0), (0, 0, 0, 0)))["twin-poses"].detail


@pytest.mark.parametrize("seed", range(5))
def test_distances_to_a_triangle_are_those_to_the_nearest_of_many_points_on_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, c = rng.normal(size=(3, 3))
    steps = np.linspace(0.0, 1.0, 401)
    u, v = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, steps))
    on_it = (a + u * (b - a) + v * (c - a))[(u + v <= 1.0 + 1e-12).reshape(-1)]
    for point in rng.normal(scale=2.0, size=(60, 3)):
        nearest = float(np.linalg.norm(on_it - point, axis=1).min())
        assert math.sqrt(_square_distance(point, a, b, c)) == pytest.approx(nearest, abs=1e-2)
        assert math.sqrt(_square_distance(point, a, b, c)) <= nearest + 1e-12


def test_points_are_on_a_surface_within_the_tolerance() -> None:
    surface = Surface(cylinder(64))
    assert surface.holds(surface.samples, 1e-9)
    assert surface.holds(surface.samples + np.array([0.0, 0.0, 9e-5]), 1e-4)
    assert not surface.holds(surface.samples + np.array([0.0, 0.0, 2e-4]), 1e-4)


def test_a_point_among_the_faces_of_a_box_that_is_not_full_may_be_on_none_of_them() -> None:
    tall = Surface(cylinder(5))
    boxed, centres, halves = tall.object_.boxes
    assert boxed[-1, -1] == -1
    among = centres[:, -1] + halves[:, -1] * np.random.default_rng(2).uniform(-1.0, 1.0, (20, 3))
    assert not all(tall.holds(point[None, :], 1e-4) for point in among)


def test_moments_do_not_depend_on_how_the_surface_is_cut() -> None:
    square = Object.from_arrays(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2], [0, 2, 3]])
    corners = np.vstack([square.vertices, [[0.3, 0.6, 0.0]]])
    other = Object.from_arrays(corners, [[0, 2, 4], [2, 3, 4], [3, 1, 4], [1, 0, 4]])
    for ours, theirs in zip(Surface(square).moments, Surface(other).moments, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-15)
    np.testing.assert_allclose(Surface(square).moments[0], [0.5, 0.5, 0.0])
    np.testing.assert_allclose(Surface(square).moments[1], np.diag([1 / 12, 1 / 12, 0.0]), atol=1e-15)
