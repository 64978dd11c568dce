import numpy as np
import pytest

from voa_meshes import write_stl
from voa_service.ros_tools.meshes import bounds_of, vectors_of

VERTICES = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, -0.3]])
FACES = np.array([[0, 2, 1], [0, 1, 3]])
STL = write_stl(VERTICES, FACES)


def test_corners_come_three_for_each_triangle() -> None:
    assert np.array(vectors_of(STL)) == pytest.approx(VERTICES[FACES.ravel()])


def test_the_bounding_box_is_that_of_the_mesh_in_its_own_frame() -> None:
    bounds = bounds_of(STL)
    assert bounds.low == pytest.approx((0.0, 0.0, -0.3))
    assert bounds.high == pytest.approx((0.1, 0.2, 0.0))
