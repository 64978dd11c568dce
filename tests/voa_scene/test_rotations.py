"""Rotations of plain Python against numpy's matrices."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voa_scene.rotations import about_z, along, cross, of_axes, unit
from voa_scene.shapes import Quaternion, Vector


def matrix(q: Quaternion) -> np.ndarray:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


parts = st.floats(-1.0, 1.0)


@given(st.tuples(parts, parts, parts, parts).filter(lambda q: math.hypot(*q) > 0.1))
def test_axes_and_quaternions_agree(q: Quaternion) -> None:
    length = math.hypot(*q)
    rotation = matrix((q[0] / length, q[1] / length, q[2] / length, q[3] / length))
    x, y, z = ((float(a), float(b), float(c)) for a, b, c in rotation.T)
    assert np.allclose(matrix(of_axes(x, y, z)), rotation, atol=1e-6)


@pytest.mark.parametrize("axes", [((1, 0, 0), (0, -1, 0), (0, 0, -1)), ((-1, 0, 0), (0, 1, 0), (0, 0, -1))])
def test_half_turns_have_no_division_by_zero(axes: tuple[Vector, Vector, Vector]) -> None:
    assert np.allclose(matrix(of_axes(*axes)), np.array(axes, dtype=float).T)


def test_about_z_turns_counter_clockwise() -> None:
    assert np.allclose(matrix(about_z(math.pi / 2)) @ [1, 0, 0], [0, 1, 0])


def test_vectors() -> None:
    assert cross((1, 0, 0), (0, 1, 0)) == (0, 0, 1)
    assert unit((0, 3, 4)) == (0, 0.6, 0.8)
    assert along((1, 1, 1), (0, 0, 1), 2) == (1, 1, 3)
