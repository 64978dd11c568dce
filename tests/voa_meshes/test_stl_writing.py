"""STL that is written is read back."""

import numpy as np

from voa_meshes import read_mesh, write_stl

VERTICES = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.125], [1.0, 0.0, 0.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 1, 4]])


def test_triangles_are_read_back_with_their_order() -> None:
    content = write_stl(VERTICES, FACES)
    assert len(content) == 84 + 50 * 3
    triangles = read_mesh(content, "stl")
    assert np.array_equal(triangles.vertices[triangles.faces], VERTICES[FACES])


def test_normals_point_outwards_and_a_triangle_without_an_area_has_none() -> None:
    content = write_stl(VERTICES, FACES)
    normals = [np.frombuffer(content, "<f4", 3, 84 + 50 * face).tolist() for face in range(3)]
    assert normals == [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]
