import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core import large_pages
from voa_core.prediction import Prediction
from voa_core.rules.exponential import Exponential
from voa_core.weights import Weigher

PAGE = 2**21


@pytest.mark.parametrize(
    "shape",
    [(0, 4), (3, 5), (400, 400), (500, 500), (511, 512), (512, 512), (600, 600), (724, 724), (1000, 1000)],
)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_they_are_zeros_of_the_shape_and_type_that_can_be_written(
    shape: tuple[int, int], dtype: type[np.floating]
) -> None:
    made = large_pages.zeros(shape, dtype)
    assert (made.shape, made.dtype) == (shape, np.dtype(dtype))
    assert made.flags.c_contiguous
    assert not made.any()
    made[...] = 1.0
    assert made.all()


@pytest.mark.parametrize("shape", [(500, 500), (512, 512), (700, 700), (1000, 1000)])
def test_what_fills_most_of_its_pages_begins_with_one(shape: tuple[int, int]) -> None:
    assert large_pages.zeros(shape, np.float64).ctypes.data % PAGE == 0


@pytest.mark.parametrize(("shape", "dtype"), [((3, 3), np.float64), ((400, 400), np.float64), ((500, 500), np.float32)])
def test_what_would_leave_much_of_a_page_unused_does_not(shape: tuple[int, int], dtype: type[np.floating]) -> None:
    assert large_pages.zeros(shape, dtype).base is None


def test_kept_weights_of_500_poses_begin_with_a_large_page() -> None:
    ranges = np.random.default_rng(1).uniform(0.5, 1.5, (500, 4))
    prediction = Prediction.of_dense(lidar_of(4, range_max=2.0).grid, ranges)
    kept = Weigher.of(Exponential(2.0), prediction, np.float64, keep=True).matrix
    assert kept is not None
    assert kept.ctypes.data % PAGE == 0
    assert kept == pytest.approx(np.exp(-np.sqrt(((ranges[:, None] - ranges[None]) ** 2).sum(axis=2))), abs=1e-12)
