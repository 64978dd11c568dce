"""Priors of scenarios as the fleet draws from them: equal to those of the service, in every form."""

from dataclasses import replace

import numpy as np
import pytest

from voa_core.poses import PoseSet
from voa_core.priors import Category, pose_model
from voa_fleet.episodes.priors import prior_of
from voa_fleet.errors import FleetError, InvalidObject
from voa_fleet.world.objects import FleetObject
from voa_msgs.priors import PoseCategory, PoseModelPrior, Prior


def with_prior(mug: FleetObject, prior: Prior | None) -> FleetObject:
    return replace(mug, scenario=mug.scenario.model_copy(update={"prior": prior}))


def model(*categories: dict[str, object]) -> PoseModelPrior:
    return PoseModelPrior.model_validate({"form": "pose_model", "categories": list(categories)})


def by_the_core(mug: FleetObject, prior: PoseModelPrior) -> list[float]:
    poses = mug.scenario.poses
    listed = PoseSet.from_arrays(
        [pose.name for pose in poses],
        np.array([pose.position for pose in poses]),
        np.array([pose.quaternion_wxyz for pose in poses]),
    )
    belief: list[float] = pose_model(listed, [_category(mug, each) for each in prior.categories]).p.tolist()
    return belief


def _category(mug: FleetObject, each: PoseCategory) -> Category:
    mean, covariance = each.mean_xy, each.covariance_xy
    return Category(
        mug.poses.index(each.pose),
        each.probability,
        each.yaw_mean_rad,
        each.yaw_concentration,
        None if mean is None else (mean[0], mean[1]),
        None if covariance is None else ((covariance[0][0], covariance[0][1]), (covariance[1][0], covariance[1][1])),
    )


def test_no_prior_is_uniform_and_a_list_is_normalised(mug: FleetObject) -> None:
    assert prior_of(with_prior(mug, None)) == [1 / 6] * 6
    assert prior_of(with_prior(mug, [0.0, 0.0, 0.25, 0.75, 0.0, 0.0])) == [0.0, 0.0, 0.25, 0.75, 0.0, 0.0]
    assert sum(prior_of(with_prior(mug, [0.1] * 5 + [0.5000004]))) == pytest.approx(1.0, abs=1e-15)


def test_a_model_of_categories_gives_the_prior_of_the_service(mug: FleetObject) -> None:
    references = _one_of_each_rest(mug)
    shares = np.arange(1.0, len(references) + 1.0)
    shares /= shares.sum()
    covariance = [[4e-4, 1e-4], [1e-4, 9e-4]]
    prior = model(
        *(
            {"pose": name, "probability": share, "yaw_mean_rad": 0.4, "yaw_concentration": 2.0}
            | {"mean_xy": [0.01, -0.02], "covariance_xy": covariance}
            for name, share in zip(references, shares.tolist(), strict=True)
        )
    )
    np.testing.assert_allclose(prior_of(with_prior(mug, prior)), by_the_core(mug, prior), atol=1e-12)
    assert len(set(np.round(prior_of(with_prior(mug, prior)), 6))) > len(references)


def _one_of_each_rest(mug: FleetObject) -> list[str]:
    return [rest.poses[0] for rest in mug.physics.rests.values() if rest.poses]


def test_categories_that_do_not_fit_the_poses_are_refused(mug: FleetObject) -> None:
    first, *_ = _one_of_each_rest(mug)
    for prior, words in (
        (model({"pose": first, "probability": 1.0}), "expected a category for pose"),
        (model({"pose": first, "probability": 0.5}, {"pose": first, "probability": 0.5}), "as another category's"),
    ):
        with pytest.raises(InvalidObject, match=words):
            prior_of(with_prior(mug, prior))
    with pytest.raises(FleetError, match="no pose 'X'"):
        prior_of(with_prior(mug, model({"pose": "X", "probability": 1.0})))
    with pytest.raises(InvalidObject, match="one per pose, got 2"):
        prior_of(with_prior(mug, [0.5, 0.5]))
