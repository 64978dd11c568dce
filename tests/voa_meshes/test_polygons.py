"""Polygons are cut so that nothing is left out, nothing is twice, and every corner stays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray

from tests.voa_meshes.files import POINTS, POLYGONS, assert_solid, rolled
from voa_meshes.polygons import triangulated
from voa_meshes.triangles import Triangles, UnreadableMesh


def cut(points: ArrayLike) -> NDArray[np.int64]:
    """Cut a polygon into triangles."""
    vertices = np.array(points, dtype=np.float64)
    size = np.array([len(vertices)])
    return triangulated(vertices, np.arange(len(vertices)), size, lambda index: f"face {index + 1}")


def flat(points: list[tuple[float, float]]) -> list[tuple[float, float, float]]:
    return [(x, y, 0.0) for x, y in points]


def areas(points: ArrayLike, faces: NDArray[np.int64]) -> NDArray[np.float64]:
    corners = np.array(points, dtype=np.float64)[faces]
    crossed: NDArray[np.float64] = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return crossed


def around(faces: NDArray[np.int64]) -> set[tuple[int, int]]:
    """Sides that no other triangle has the other way round."""
    sides = [(int(face[k]), int(face[(k + 1) % 3])) for face in faces for k in range(3)]
    assert len(set(sides)) == len(sides)
    return {(a, b) for a, b in sides if (b, a) not in sides}


@given(st.lists(st.floats(0.05, 1.0), min_size=3, max_size=24), st.integers(0, 2**32 - 1))
def test_a_polygon_seen_whole_from_a_point_inside_is_cut_whole(radii: list[float], seed: int) -> None:
    angles = np.arange(len(radii)) * 2.0 * np.pi / len(radii)
    ring = np.stack([radii * np.cos(angles), radii * np.sin(angles), 0.0 * angles], axis=1)
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    points = ring @ turn.T + [3.0, -2.0, 1.0]
    faces = cut(points)
    assert len(faces) == len(radii) - 2
    assert around(faces) == {(k, (k + 1) % len(radii)) for k in range(len(radii))}
    along = areas(points, faces) @ turn[:, 2]
    assert (along > -1e-12).all()
    assert along.sum() == pytest.approx(0.5 * np.cross(ring, np.roll(ring, -1, axis=0))[:, 2].sum())


@pytest.mark.parametrize("first", range(6))
def test_a_concave_polygon_is_cut_right_whichever_corner_is_first(first: int) -> None:
    polygons = rolled(POLYGONS, first)
    corners, sizes = np.concatenate([np.array(p) for p in polygons]), np.array([len(p) for p in polygons])
    faces = triangulated(POINTS, corners, sizes, str)
    assert len(faces) == 20
    assert around(faces) == set()
    assert_solid(Triangles(POINTS, faces))


@pytest.mark.parametrize("first", range(4))
def test_an_arrowhead_is_cut_at_its_notch(first: int) -> None:
    points = flat([(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (1.5, 1.0)])
    faces = cut(np.roll(points, first, axis=0))
    assert (areas(np.roll(points, first, axis=0), faces)[:, 2] > 0.0).all()


def test_corners_on_a_straight_side_stay() -> None:
    comb = flat([(x, 0.0) for x in range(6)] + [(5.0, 1.0), (4.0, 1.0), (3.0, 0.5), (2.0, 1.0), (1.0, 1.0), (0.0, 1.0)])
    faces = cut(comb)
    assert len(faces) == len(comb) - 2
    assert around(faces) == {(k, (k + 1) % len(comb)) for k in range(len(comb))}
    assert areas(comb, faces)[:, 2].sum() == pytest.approx(4.5)


@given(st.lists(st.floats(0.2, 1.0), min_size=3, max_size=9), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_corners_that_rounding_moves_off_a_straight_side_stay(radii: list[float], between: int, seed: int) -> None:
    angles = np.arange(len(radii)) * 2.0 * np.pi / len(radii)
    ring = np.stack([radii * np.cos(angles), radii * np.sin(angles), 0.0 * angles], axis=1)
    steps = np.linspace(0.0, 1.0, between, endpoint=False)[:, None]
    sides = [a + steps * (b - a) for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    points = (np.concatenate(sides) @ turn.T + [0.3, 0.7, -0.2]).astype(np.float32).astype(np.float64)
    faces = cut(points)
    assert len(faces) == len(points) - 2
    assert around(faces) == {(k, (k + 1) % len(points)) for k in range(len(points))}


def test_a_polygon_that_is_not_planar_is_cut_in_its_best_plane() -> None:
    saddle = [(0.0, 0.0, 0.1), (1.0, 0.0, -0.1), (1.0, 1.0, 0.1), (0.6, 0.4, 0.0), (0.0, 1.0, -0.1)]
    faces = cut(saddle)
    assert len(faces) == 3
    assert (areas(saddle, faces)[:, 2] > 0.0).all()


def test_a_hole_that_is_reached_by_a_slit_stays_a_hole() -> None:
    outer, inner = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)], [(1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)]
    keyhole = flat([*outer, outer[0], *inner, inner[0]])
    faces = cut(keyhole)
    assert len(faces) == len(keyhole) - 2
    assert areas(keyhole, faces)[:, 2].sum() == pytest.approx(8.0)


def test_a_corner_that_is_said_twice_is_one() -> None:
    assert len(cut(flat([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]))) == 2
    assert len(cut(flat([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)]))) == 0


def test_a_polygon_on_a_line_has_no_area_and_keeps_its_sides() -> None:
    line = flat([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.5, 0.0)])
    assert len(cut(line)) == 2
    assert not areas(line, cut(line)).any()


@pytest.mark.parametrize(
    "crossing",
    [
        [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)],
        [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 1.0)],
        [(0.0, 1.0), (0.6, -0.8), (-0.95, 0.3), (0.95, 0.3), (-0.6, -0.8)],
    ],
    ids=["bow tie", "uneven bow tie", "pentagram"],
)
def test_sides_that_cross_are_refused(crossing: list[tuple[float, float]]) -> None:
    with pytest.raises(UnreadableMesh, match="face 1: the sides of its polygon cross"):
        cut(flat(crossing))


def test_a_polygon_of_many_corners_is_cut_in_time() -> None:
    angles = np.arange(20_000) * 2.0 * np.pi / 20_000
    radii = 1.0 + 0.3 * np.sin(40.0 * angles)
    ring = np.stack([radii * np.cos(angles), radii * np.sin(angles), 0.0 * angles], axis=1)
    assert len(cut(ring)) == 19_998


def test_polygons_keep_their_order() -> None:
    square = np.array(flat([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]))
    corners, sizes = np.array([0, 1, 2, 0, 1, 2, 3, 0, 2, 3]), np.array([3, 4, 3])
    assert triangulated(square, corners, sizes, str).tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 2, 3]]
