import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.support.shapes import box
from voa_fleet.world.meshes import Mesh
from voa_setup.grasps.surface import FEWEST, GROUP, MOST, sample_surface

SHEET = Mesh(
    np.array([[0, 0, 0], [0.3, 0, 0], [0.3, 0.1, 0], [0.1, 0.1, 0]], dtype=float),
    np.array([[0, 1, 3], [1, 2, 3], [0, 0, 1]], dtype=np.int32),
)


def test_points_lie_on_the_surface_evenly_by_area() -> None:
    surface = sample_surface(box(), 0)
    size = np.array([0.12, 0.07, 0.045])
    relative = np.abs((surface.points - surface.centre) / (size / 2.0))
    assert relative.max() == pytest.approx(1.0)
    assert np.allclose(relative[np.arange(len(relative)), np.abs(surface.normals).argmax(axis=1)], 1.0)
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    shares = (np.abs(surface.normals) > 0.5).mean(axis=0)
    assert shares == pytest.approx(areas / areas.sum(), abs=0.01)


def test_neighbours_are_about_as_far_apart_as_stated() -> None:
    points = sample_surface(SHEET, 0).points
    apart, _ = KDTree(points).query(points, k=2)
    assert 0.0015 < np.median(apart[:, 1]) < 0.004
    assert (apart[:, 1] > 0.0007).mean() > 0.95


def test_faces_without_area_get_no_points_and_their_number_is_bounded() -> None:
    assert FEWEST <= len(sample_surface(SHEET, 0).points) <= MOST
    assert len(sample_surface(SHEET, 0, most=100).points) == 100
    assert np.isfinite(sample_surface(SHEET, 0).normals).all()


def test_every_point_is_in_one_group_and_its_ball() -> None:
    surface = sample_surface(box(), 0)
    members = surface.groups[surface.groups >= 0]
    assert sorted(members) == list(range(len(surface.points)))
    assert surface.groups.shape[1] == GROUP
    for group, centre, radius in zip(surface.groups, surface.centres, surface.radii, strict=True):
        inside = surface.points[group[group >= 0]]
        assert np.linalg.norm(inside - centre, axis=1).max() <= radius + 1e-12


def test_a_mesh_without_area_is_refused() -> None:
    with pytest.raises(ValueError, match="expected a mesh with area, got 1 faces without"):
        sample_surface(Mesh(SHEET.vertices, SHEET.faces[2:]), 0)
