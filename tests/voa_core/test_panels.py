from typing import Any

import numpy as np
import pytest

from voa_core.kernels import Array
from voa_core.panels import Panels, size_in_panels

TYPES = [np.float64, np.float32]


def matrix(scans: int, poses: int, dtype: Any) -> Array:
    """Weights (scans, poses), all of which differ."""
    return np.arange(1, scans * poses + 1, dtype=dtype).reshape(scans, poses)


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize(
    ("scans", "poses"), [(1, 1), (31, 17), (32, 16), (33, 15), (64, 3), (65, 40), (130, 2), (0, 3)]
)
def test_weights_are_read_as_they_were_written(scans: int, poses: int, dtype: Any) -> None:
    weights = matrix(scans, poses, dtype)
    for order in ("C", "F"):
        panels = Panels.of(np.asarray(weights, order=order))
        assert panels.scans == scans
        assert panels.nbytes == size_in_panels(scans, poses, weights.dtype)
        read = panels.read(np.arange(scans), np.arange(poses))
        assert read.dtype == dtype
        np.testing.assert_array_equal(read, weights)


@pytest.mark.parametrize("dtype", TYPES)
def test_some_weights_are_read_in_any_order_and_more_than_once(dtype: Any) -> None:
    weights = matrix(100, 40, dtype)
    scans, poses = np.array([99, 0, 64, 31, 32, 0]), np.array([39, 16, 0, 16])
    np.testing.assert_array_equal(Panels.of(weights).read(scans, poses), weights[np.ix_(scans, poses)])


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("at_once", [1, 7, 32, 50, 200])
def test_weights_may_be_written_some_scans_at_a_time(at_once: int, dtype: Any) -> None:
    weights = matrix(130, 5, dtype)
    panels = Panels.empty(130, 5, weights.dtype)
    for first in range(0, len(weights), at_once):
        panels.write(first, weights[first : first + at_once])
    np.testing.assert_array_equal(panels.numbers, Panels.of(weights).numbers)


def test_the_weights_of_a_pose_in_a_panel_take_256_bytes_and_the_rest_of_the_last_panel_is_0() -> None:
    weights = matrix(65, 3, np.float32)
    panels = Panels.of(weights)
    assert panels.numbers.shape == (2, 3, 64)
    np.testing.assert_array_equal(panels.numbers[0, 1], weights[:64, 1])
    assert panels.numbers[1, :, 0].tolist() == weights[64].tolist()
    assert not panels.numbers[1, :, 1:].any()
    assert Panels.of(matrix(65, 3, np.float64)).numbers.shape == (3, 3, 32)


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("poses", [1, 2, 15, 16, 17, 31, 32, 33, 64, 65, 100])
def test_weights_of_pairs_stand_on_both_sides_of_the_diagonal(poses: int, dtype: Any) -> None:
    upper = np.triu(matrix(poses, poses, dtype))
    panels = Panels.of_pairs(upper[np.triu_indices(poses)], poses)
    np.testing.assert_array_equal(panels.numbers, Panels.of(upper + np.triu(upper, 1).T).numbers)
