import math

import numpy as np
import pytest

from tests.support.twin import rotation_of
from voa_core.errors import InvalidInput
from voa_core.geometry import matrices_of_quaternions, quaternion_of_matrix, turn, upright_rotation


def test_a_quarter_turn_about_the_vertical_takes_x_to_y() -> None:
    half = math.sqrt(0.5)
    matrix = matrices_of_quaternions(np.array([[half, 0.0, 0.0, half]]))[0]
    np.testing.assert_allclose(matrix @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(matrix, turn(math.pi / 2), atol=1e-15)


def test_quaternions_are_normalised_and_agree_with_the_twin() -> None:
    quaternions = np.random.default_rng(0).normal(size=(50, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True) / 1.04
    matrices = matrices_of_quaternions(quaternions)
    np.testing.assert_allclose(matrices, [rotation_of(list(q)) for q in quaternions], atol=1e-14)


def test_a_quaternion_far_from_unit_length_is_refused_with_its_norm_and_place() -> None:
    with pytest.raises(InvalidInput, match=r"quaternion_wxyz: expected a unit quaternion, got norm 2 at 1"):
        matrices_of_quaternions(np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0]]))


def test_quaternions_come_back_from_matrices_with_w_not_negative() -> None:
    quaternions = np.random.default_rng(1).normal(size=(50, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    half_turns = np.eye(4)[1:]
    for quaternion in np.concatenate([quaternions, half_turns]):
        matrix = matrices_of_quaternions(quaternion[None])[0]
        back = quaternion_of_matrix(matrix)
        assert back[0] >= 0.0
        np.testing.assert_allclose(matrices_of_quaternions(back[None])[0], matrix, atol=1e-13)


@pytest.mark.parametrize("up", [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, -0.48, 0.64]])
def test_upright_rotations_are_rotations_that_turn_up_to_the_vertical(up: list[float]) -> None:
    rotation = upright_rotation(np.array(up))
    np.testing.assert_allclose(rotation @ up, [0.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
