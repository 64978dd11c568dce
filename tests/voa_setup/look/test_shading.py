"""Shaded pictures: the object fills its silhouette without gaps, and the nearest face is seen."""

import numpy as np
import pytest

from tests.voa_setup.look.scenes import box
from voa_fleet.world.meshes import Mesh
from voa_setup.look.shading import shade
from voa_setup.look.views import View, front_view, top_view


def ball(rings: int = 40) -> Mesh:
    """A ball of radius 0.05 m of many small and some long faces."""
    polar = np.linspace(0.0, np.pi, rings + 1)
    around = np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)
    points = [[np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)] for p in polar for a in around]
    n = len(around)
    faces = []
    for ring in range(rings):
        for step in range(n):
            a, b = ring * n + step, ring * n + (step + 1) % n
            faces += [[a, a + n, b + n], [a, b + n, b]]
    return Mesh(0.05 * np.array(points), np.array(faces, dtype=np.int32))


def area(mesh: Mesh, view: View, pixels: int = 300) -> float:
    """Area of the silhouette, square metres."""
    picture = shade(mesh, view, pixels)
    left, right, bottom, top = picture.extent
    return float(picture.pixels[..., 3].mean() * (right - left) * (top - bottom))


@pytest.mark.parametrize(("view", "expected"), [(front_view(), 0.04 * 0.05), (top_view(), 0.04 * 0.06)])
def test_a_box_fills_its_silhouette(view: View, expected: float) -> None:
    picture = shade(box(), view, 300)
    covered = picture.pixels[..., 3] > 0.0
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    assert covered[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all()
    assert area(box(), view) == pytest.approx(expected, rel=0.01)


def test_a_ball_of_many_faces_has_no_gap_between_them() -> None:
    covered = shade(ball(), front_view(), 300).pixels[..., 3] > 0.0
    assert area(ball(), front_view()) == pytest.approx(np.pi * 0.05**2, rel=0.01)
    for row in covered:
        columns = np.flatnonzero(row)
        assert len(columns) == 0 or row[columns[0] : columns[-1] + 1].all()


@pytest.mark.parametrize("flip", [False, True])
def test_the_nearest_face_is_seen_whatever_its_direction(flip: bool) -> None:
    """A slanted plate lies over a level one: its middle has another brightness than where it is alone."""
    level = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]
    slanted = [[-0.5, -0.5, 0.1], [0.5, -0.5, 0.1], [0.5, 0.5, 0.9], [-0.5, 0.5, 0.9]]
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], dtype=np.int32)
    mesh = Mesh(np.array(level + slanted), faces[:, ::-1].copy() if flip else faces)
    picture = shade(mesh, top_view(), 101).pixels
    middle, outside = picture[52, 45], picture[52, 14]
    assert middle[3] == outside[3] == 1.0
    assert np.abs(middle[:3] - outside[:3]).max() > 0.02
    upside_down = shade(mesh, View(np.array([1.0, 0, 0]), np.array([0, -1.0, 0]), "x", "-y"), 101).pixels
    assert upside_down[52, 45] == pytest.approx(upside_down[52, 14])  # from below the level plate hides the other


def test_equal_meshes_give_equal_pictures() -> None:
    assert np.array_equal(shade(ball(), top_view(), 120).pixels, shade(ball(), top_view(), 120).pixels)


def test_faces_seen_edge_on_and_without_area_are_left_out() -> None:
    sheet = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]), np.array([[0, 1, 2], [0, 2, 3], [0, 0, 1]]))
    assert shade(sheet, front_view(), 50).pixels[..., 3].sum() == pytest.approx(2500, rel=0.05)
    assert shade(sheet, top_view(), 50).pixels[..., 3].sum() == 0.0
