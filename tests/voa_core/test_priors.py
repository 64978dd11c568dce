import math
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import UPRIGHT, standing
from voa_core.errors import InvalidInput, NoMesh
from voa_core.poses import PoseSet, generate
from voa_core.priors import Category, pose_model
from voa_core.stable_poses import StablePose

HALF = math.sqrt(0.5)
UP = StablePose((0.0, 0.0, 0.05), UPRIGHT, 0.4)
SIDE = StablePose((0.0, 0.0, 0.03), (HALF, HALF, 0.0, 0.0), 0.6)
YAWS = [0.0, math.pi / 2, math.pi]
POSES = generate([UP, SIDE], YAWS, [[0.0, 0.0]])
"""Upright at three yaws, then on its side at three yaws."""


def test_each_category_keeps_its_probability_however_many_poses_stand_for_it() -> None:
    poses = PoseSet.from_arrays(
        ["up", "side 0", "side 90"],
        np.zeros((3, 3)),
        np.array([UPRIGHT, SIDE.quaternion_wxyz, (0.5, 0.5, 0.5, 0.5)]),
    )
    belief = pose_model(poses, [Category(0, 0.7, yaw_concentration=3.0), Category(1, 0.3)])
    np.testing.assert_allclose(belief.p, [0.7, 0.15, 0.15], atol=1e-12)


def test_yaws_are_von_mises_and_counted_from_the_reference() -> None:
    belief = pose_model(POSES, [Category(1, 0.4, yaw_mean_rad=0.1, yaw_concentration=2.0), Category(3, 0.6)])
    density = np.array([math.exp(2.0 * math.cos(yaw - math.pi / 2 - 0.1)) for yaw in YAWS])
    np.testing.assert_allclose(belief.p[:3], 0.4 * density / density.sum(), atol=1e-12)
    np.testing.assert_allclose(belief.p[3:], 0.2, atol=1e-12)


def test_places_are_normal() -> None:
    poses = standing((0.1, 0.0, 0.0), (0.2, 0.1, 0.0), (0.0, 0.3, 0.0))
    covariance = ((0.02, 0.005), (0.005, 0.01))
    belief = pose_model(poses, [Category(0, 1.0, mean_xy=(0.1, 0.1), covariance_xy=covariance)])
    inverse = np.linalg.inv(np.array(covariance))
    density = [
        math.exp(-0.5 * float(off @ inverse @ off))
        for off in (np.array([x - 0.1, y - 0.1]) for x, y in ((0.1, 0.0), (0.2, 0.1), (0.0, 0.3)))
    ]
    np.testing.assert_allclose(belief.p, np.array(density) / sum(density), atol=1e-12)


def test_a_place_thousands_of_standard_deviations_off_still_has_a_share() -> None:
    poses = standing((50.0, 0.0, 0.0), (50.0, 0.0, 0.0))
    belief = pose_model(poses, [Category(0, 1.0, mean_xy=(0.0, 0.0), covariance_xy=((1e-4, 0.0), (0.0, 1e-4)))])
    np.testing.assert_allclose(belief.p, [0.5, 0.5])


def test_places_too_far_off_for_a_number_leave_no_prior() -> None:
    poses = standing((1e200, 0.0, 0.0))
    with pytest.raises(InvalidInput, match="prior: expected a sum within 1e-6 of 1"):
        pose_model(poses, [Category(0, 1.0, mean_xy=(0.0, 0.0), covariance_xy=((1e-4, 0.0), (0.0, 1e-4)))])


def test_a_category_of_probability_0_is_impossible() -> None:
    belief = pose_model(POSES, [Category(0, 0.0), Category(3, 1.0)])
    np.testing.assert_allclose(belief.p, [0.0] * 3 + [1 / 3] * 3, atol=1e-12)


@pytest.mark.parametrize(
    ("categories", "message"),
    [
        (
            [Category(0, 0.4), Category(3, 0.5)],
            "categories: expected probabilities within 1e-6 of a sum of 1, got a sum",
        ),
        (
            [Category(0, 0.5), Category(2, 0.5)],
            "categories: expected poses that rest differently, got 'S1/0deg' in those of 'S1/0deg' and of 'S1/180deg'",
        ),
        ([Category(0, 1.0)], "categories: expected a category for every pose, got none for 'S2/0deg'"),
        ([Category(6, 1.0)], "reference: expected the index of a pose, 0 to 5, got 6"),
        ([Category(-1, 1.0)], "reference: expected the index of a pose, 0 to 5, got -1"),
        ([], "categories: expected probabilities within 1e-6 of a sum of 1, got a sum of 0"),
    ],
)
def test_categories_that_do_not_part_the_poses_are_refused(categories: list[Category], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        pose_model(POSES, categories)


@pytest.mark.parametrize("covariance", [((1.0, 0.5), (0.4, 1.0)), ((1.0, 2.0), (2.0, 1.0)), ((0.0, 0.0), (0.0, 1.0))])
def test_a_covariance_that_is_none_is_refused(covariance: Any) -> None:
    category = Category(0, 1.0, mean_xy=(0.0, 0.0), covariance_xy=covariance)
    with pytest.raises(InvalidInput, match="covariance_xy: expected a symmetric positive definite matrix"):
        pose_model(standing((0.0, 0.0, 0.0)), [category])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"probability": -0.1}, "probability: expected a number of at least 0.0"),
        ({"yaw_mean_rad": math.nan}, "yaw_mean_rad: expected a finite number"),
        ({"yaw_concentration": -1.0}, "yaw_concentration: expected a number of at least 0.0"),
        ({"mean_xy": (0.0, 0.0)}, "mean_xy, covariance_xy: expected both or neither, got one of them"),
    ],
)
def test_a_category_that_is_none_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Category(**{"reference": 0, "probability": 1.0, **arguments})


def test_poses_without_geometry_have_no_such_prior() -> None:
    with pytest.raises(NoMesh, match="a pose_model prior needs position and quaternion_wxyz of every pose"):
        pose_model(PoseSet.named(["A"]), [Category(0, 1.0)])
