"""Beliefs and priors from messages: numbers, the scenario's prior, a model over poses, and digests for the cache."""

import math

import pytest

from tests.support.scenarios import core_scenario
from voa_core.errors import InvalidInput, UnknownName
from voa_core.filtering import Belief
from voa_core.poses import PoseSet
from voa_msgs.priors import PoseModelPrior
from voa_service.mapping.beliefs import belief_digest, belief_of, prior_of

GIVEN = [0.2, 0.3, 0.5]
QUARTER = [math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]
POSES = PoseSet.from_arrays(["A", "B"], [[0.0, 0.0, 0.0]] * 2, [[1.0, 0.0, 0.0, 0.0], QUARTER])


def model(pose: str) -> PoseModelPrior:
    category = {"pose": pose, "probability": 1.0, "yaw_mean_rad": 0.0, "yaw_concentration": 1.0}
    spread = {"mean_xy": [0.0, 0.0], "covariance_xy": [[1.0, 0.0], [0.0, 1.0]]}
    return PoseModelPrior.model_validate({"form": "pose_model", "categories": [category | spread]})


def test_a_belief_is_the_given_one_or_else_the_prior_of_the_scenario() -> None:
    scenario = core_scenario(prior=GIVEN)
    stored = Belief.of([0.5, 0.25, 0.25])
    assert belief_of(None, scenario) is scenario.prior
    assert belief_of(stored, scenario) is stored
    assert belief_of([0.0, 0.0, 1.0], scenario).p.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("numbers", [[0.5, 0.5], [0.5, 0.5, 0.5]])
def test_numbers_that_are_no_belief_are_refused_under_the_name_of_their_field(numbers: list[float]) -> None:
    with pytest.raises(InvalidInput, match=r"^sensor_belief: "):
        belief_of(numbers, core_scenario(), "sensor_belief")


def test_a_prior_is_uniform_or_given_by_numbers() -> None:
    assert prior_of(None, POSES).p.tolist() == [0.5, 0.5]
    assert prior_of([0.25, 0.75], POSES).p.tolist() == [0.25, 0.75]


def test_a_model_of_poses_weighs_each_pose_by_its_yaw() -> None:
    first, second = prior_of(model("A"), POSES).p.tolist()
    assert first / second == pytest.approx(math.e), "exp(cos 0 - cos 90 deg), at a concentration of 1"


def test_a_model_of_an_unknown_pose_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName) as refused:
        prior_of(model("C"), POSES)
    assert (refused.value.what, refused.value.known) == ("pose", ["A", "B"])


def test_digests_are_equal_for_equal_beliefs_of_one_origin_alone() -> None:
    stored = Belief.of(GIVEN)
    assert belief_digest(None) is None
    assert belief_digest(GIVEN) == belief_digest(list(GIVEN))
    assert belief_digest(stored) == belief_digest(Belief.of(GIVEN))
    assert len({belief_digest(GIVEN), belief_digest(GIVEN[::-1]), belief_digest(stored)}) == 3


def test_beliefs_with_equal_probabilities_and_other_logarithms_have_other_digests() -> None:
    rounded = Belief.of([0.0, 0.5, 0.5])
    improbable = Belief(rounded.p, Belief.of([0.25, 0.25, 0.5]).log_p)
    assert belief_digest(rounded) != belief_digest(improbable)
