"""The loops over pairs, each against the obvious numpy."""

import numpy as np
import pytest

from voa_core.kernels import disagreements, mirror, squared_distances, squared_distances_among

SCANS = np.random.default_rng(0).uniform(0.1, 2.0, (5, 7))


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-14), (np.float32, 1e-6)])
def test_squared_distances_are_those_of_numpy(dtype: type[np.floating], tolerance: float) -> None:
    observed, predicted = SCANS[:2].astype(dtype), SCANS.astype(dtype)
    expected = ((SCANS[:2, None] - SCANS[None]) ** 2).sum(axis=2)
    out = np.full((2, 5), -1.0, dtype=dtype)
    squared_distances(observed, predicted, out)
    np.testing.assert_allclose(out, expected, rtol=0, atol=10 * tolerance)


def test_a_triangle_holds_each_pair_once_and_0_for_equal_scans() -> None:
    out, among = np.full((5, 5), -1.0), np.full(15, -1.0)
    squared_distances(SCANS, SCANS, out)
    squared_distances_among(SCANS, among)
    np.testing.assert_allclose(among, out[np.triu_indices(5)], rtol=0, atol=1e-14)
    assert among[[0, 5, 9, 12, 14]].tolist() == [0.0] * 5


@pytest.mark.parametrize("n", [0, 1, 5, 16, 17, 40])
def test_a_triangle_makes_a_symmetric_matrix(n: int) -> None:
    triangle, square = np.arange(n * (n + 1) / 2), np.full((n, n), -1.0)
    mirror(triangle, square)
    np.testing.assert_array_equal(square[np.triu_indices(n)], triangle)
    np.testing.assert_array_equal(square, square.T)


def test_float32_distances_of_nearly_equal_scans_stay_millimetre_true() -> None:
    near = np.array([[1.999] * 300, [2.0] * 300], dtype=np.float32)
    out = np.zeros(3, dtype=np.float32)
    squared_distances_among(near, out)
    assert float(np.sqrt(out[1] / 300)) == pytest.approx(0.001, rel=1e-3)


def test_disagreements_count_the_beams_beyond_the_margin() -> None:
    out = np.full((2, 1), -1.0)
    disagreements(np.array([[0.5, 0.6, 0.7], [0.51, 0.6, 0.9]]), np.array([[0.5, 0.6, 0.7]]), 0.005, out)
    assert out.tolist() == [[0.0], [2.0]]
