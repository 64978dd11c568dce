import numpy as np

from voa_ros.motions import Motion, composed, inverse
from voa_setup.calibration import planar


def test_poses_are_composed_and_inverted_as_one_by_one() -> None:
    random = np.random.default_rng(0)
    ones = [Motion(*row) for row in random.uniform(-3.0, 3.0, (20, 3))]
    others = [Motion(*row) for row in random.uniform(-3.0, 3.0, (20, 3))]
    a, b = (np.array([planar.planar(each) for each in each_list]) for each_list in (ones, others))
    for row, one, other in zip(planar.composed(a, b), ones, others, strict=True):
        np.testing.assert_allclose(row, planar.planar(composed(one, other)), atol=1e-12)
    for row, one in zip(planar.inverse(a), ones, strict=True):
        np.testing.assert_allclose(row, planar.planar(inverse(one)), atol=1e-12)
