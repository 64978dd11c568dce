"""Rests of convex bodies, against trimesh's own way through the same theory and against figures worked out by hand."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from voa_core.checks import Floats
from voa_core.toppling import HOLDS_RAD, Body, rests


def body_of(points: Floats, centre: Floats) -> Body:
    hull = ConvexHull(points - centre)
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    return Body(points - centre, hull.simplices, hull.neighbors, normals, -offsets)


def prism(sides: int, height: float = 1.0) -> Floats:
    """Points of a regular prism of radius 1 about the z axis, its centre of mass at the origin."""
    turn = 2.0 * math.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (-0.5 * height, 0.5 * height)])


@given(st.integers(0, 2**32 - 1), st.integers(4, 40))
def test_every_rest_and_its_probability_is_trimesh_s(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    hull = trimesh.convex.convex_hull(rng.normal(size=(count, 3)))
    centre = rng.dirichlet(np.full(len(hull.vertices), 5.0)) @ hull.vertices
    transforms, probabilities = trimesh.poses.compute_stable_poses(hull, center_mass=centre)
    resting = rests(body_of(np.array(hull.vertices), centre), holds_rad=0.0)
    own = np.array([rest.probability for rest in resting])
    np.testing.assert_allclose(own.sum(), 1.0, atol=1e-12)
    assert len(resting) >= len(transforms)
    # trimesh takes normals together that agree to three digits: rests that lie close together count as one.
    downs = np.concatenate([[rest.down for rest in resting], -transforms[:, 2, :3]])
    _, together = connected_components(np.linalg.norm(downs[:, None] - downs, axis=2) < 2e-3)
    ours, theirs = np.split(together, [len(resting)])
    np.testing.assert_allclose(np.bincount(ours, own), np.bincount(theirs, probabilities, ours.max() + 1), atol=1e-9)


@pytest.mark.parametrize("sides", range(3, 21))
def test_a_prism_of_up_to_20_sides_rests_on_each_of_them(sides: int) -> None:
    resting = rests(body_of(prism(sides, height=4.0), np.zeros(3)))
    lying = [rest for rest in resting if abs(rest.down[2]) < 0.5]
    assert len(lying) == sides
    assert [rest.height for rest in lying] == pytest.approx([math.cos(math.pi / sides)] * sides)


@pytest.mark.parametrize("sides", [21, 24, 64, 360])
def test_a_prism_of_more_sides_rolls_and_has_one(sides: int) -> None:
    assert sum(abs(rest.down[2]) < 0.5 for rest in rests(body_of(prism(sides, height=4.0), np.zeros(3)))) == 1


@pytest.mark.parametrize(("tilt_deg", "listed"), [(8.9, False), (9.1, True)])
def test_a_tall_box_stands_if_it_withstands_nine_degrees(tilt_deg: float, listed: bool) -> None:
    width = 2.0 * math.tan(math.radians(tilt_deg))
    corners = np.array([[x, y, z] for x in (-2.0, 2.0) for y in (-0.5 * width, 0.5 * width) for z in (-1.0, 1.0)])
    standing = [rest for rest in rests(body_of(corners, np.zeros(3))) if abs(rest.down[2]) > 0.5]
    assert len(standing) == (2 if listed else 0)


def test_a_wall_that_rolls_to_its_heavy_side_rests_there_and_nowhere_else() -> None:
    resting = rests(body_of(prism(64, height=8.0), np.array([0.1, 0.0, 0.0])))
    (lying,) = [rest for rest in resting if abs(rest.down[2]) < 0.5]
    assert math.degrees(math.acos(lying.down[0])) < 3.0
    assert lying.height == pytest.approx(0.9, abs=2e-3)


def test_an_oval_wall_rests_on_either_flat_side() -> None:
    resting = rests(body_of(prism(64, height=8.0) * [1.0, 1.1, 1.0], np.zeros(3)))
    lying = [rest for rest in resting if abs(rest.down[2]) < 0.5]
    assert sorted(round(float(rest.down[0])) for rest in lying) == [-1, 1]


def test_two_rests_with_a_shallow_one_between_them_stay_two() -> None:
    """A roof upside down: its ridge is cut flat, so narrowly that it topples to either slope."""
    ridge, slope = 0.05, 1.0
    profile = [[-ridge, -0.5], [ridge, -0.5], [slope, 0.0], [-slope, 0.0]]
    points = np.array([[x, y, z] for x, z in profile for y in (-3.0, 3.0)])
    resting = rests(body_of(points, np.array([0.0, 0.0, -0.1])))
    downs = sorted(round(math.degrees(math.atan2(rest.down[0], -rest.down[2]))) for rest in resting)
    assert math.atan(ridge / 0.4) < HOLDS_RAD
    slopes = round(math.degrees(math.atan(0.5 / (slope - ridge))))
    assert downs == [-slopes, slopes, 180]


def test_a_face_cut_into_needles_is_one_face() -> None:
    rng = np.random.default_rng(3)
    rim = np.linspace(-1.0, 1.0, 200)[:, None] * [1.0, 0.0, 0.0]
    on_faces = np.concatenate([rim + np.array([0.0, y, z]) for y in (-1.0, 1.0) for z in (-0.5, 0.5)])
    inside = rng.uniform(-1.0, 1.0, (300, 3)) * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.5]
    resting = rests(body_of(np.concatenate([on_faces, inside]), np.zeros(3)))
    assert len(resting) == 6
    assert sorted(round(rest.height, 9) for rest in resting) == [0.5, 0.5, 1.0, 1.0, 1.0, 1.0]
