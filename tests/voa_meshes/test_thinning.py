"""Thinned meshes: within the bound, and close to the surface."""

import numpy as np
import pytest
import trimesh

from voa_meshes import thinned

SPHERE = trimesh.creation.icosphere(subdivisions=5, radius=0.05)  # 20 480 faces


@pytest.mark.parametrize("most", [100, 1000, 5000])
def test_a_sphere_keeps_its_shape_within_the_bound(most: int) -> None:
    vertices, faces = thinned(SPHERE.vertices, SPHERE.faces, most)
    assert most / 3 < len(faces) <= most
    radii = np.linalg.norm(vertices[np.unique(faces)], axis=1)
    assert radii.max() <= 0.05 + 1e-12
    assert radii.min() > 0.05 * (1.0 - 30.0 / most)
    assert faces.max() < len(vertices)


def test_a_mesh_within_the_bound_is_unchanged() -> None:
    vertices, faces = thinned(SPHERE.vertices, SPHERE.faces, 20_480)
    assert vertices is SPHERE.vertices
    assert faces is SPHERE.faces
