import math
from typing import Any

import numpy as np
import pytest

from voa_core.errors import InvalidInput, UnknownName
from voa_core.grasps import Choice, GraspTable, best_grasp, choose, log_outcome_weights, ranked

TABLE = GraspTable.of_successes(["TD0", "TD90", "OI90"], [[0, 9, 0], [8, 0, 0], [0, 14, 13]], 15, 3)


def test_scores_are_successes_of_attempts() -> None:
    np.testing.assert_allclose(TABLE.scores, np.array([[0, 9, 0], [8, 0, 0], [0, 14, 13]]) / 15)


@pytest.mark.parametrize(
    ("successes", "attempts", "message"),
    [
        ([[16, 0]], 15, "successes: expected whole numbers from 0 to 15, got 0 to 16"),
        ([[-1, 0]], 15, "successes: expected whole numbers from 0 to 15, got -1 to 0"),
        ([[1.5, 0]], 15, "successes: expected whole numbers from 0 to 15, got 0 to 1.5"),
        ([[1, 0]], 0, "attempts: expected at least 1, got 0"),
        ([[1, 0, 0]], 15, "successes: expected shape 1x2, got shape 1x3"),
    ],
)
def test_counts_that_cannot_be_are_refused(successes: Any, attempts: int, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        GraspTable.of_successes(["G"], successes, attempts, 2)


@pytest.mark.parametrize(
    ("names", "scores", "message"),
    [
        (["G"], [[0.5, 1.1]], "scores: expected probabilities from 0 to 1, got 0.5 to 1.1"),
        (["G"], [[-0.1, 1.0]], "scores: expected probabilities from 0 to 1, got -0.1 to 1"),
        (["G"], [[0.5]], "scores: expected shape 1x2, got shape 1x1"),
        ([], [], "grasp: expected at least one, got none"),
        (["G", "G"], [[0.5, 0.5]] * 2, "grasp: expected names that differ"),
    ],
)
def test_scores_that_cannot_be_are_refused(names: list[str], scores: Any, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        GraspTable.of_probabilities(names, scores, 2)


def test_reachable_grasps_keep_the_tables_order() -> None:
    assert TABLE.reachable(None) is TABLE
    some = TABLE.reachable(["OI90", "TD0"])
    assert some.names == ("TD0", "OI90")
    np.testing.assert_array_equal(some.scores, TABLE.scores[[0, 2]])


def test_scores_from_counts_weigh_outcomes_by_jeffreys_prior_and_given_probabilities_as_they_are() -> None:
    np.testing.assert_allclose(np.exp(TABLE.log_outcome_weights(1, True)), [8.5 / 16.0, 0.5 / 16.0, 0.5 / 16.0])
    np.testing.assert_allclose(np.exp(TABLE.log_outcome_weights(1, False)), [7.5 / 16.0, 15.5 / 16.0, 15.5 / 16.0])
    np.testing.assert_allclose(np.exp(TABLE.log_outcome_weights(1, True, 2, 1)), np.array([10.5, 2.5, 2.5]) / 19.0)
    np.testing.assert_allclose(np.exp(TABLE.log_outcome_weights(1, False, 2, 1)), np.array([8.5, 16.5, 16.5]) / 19.0)
    np.testing.assert_allclose(np.exp(TABLE.log_outcome_weights(1, True, score_floor=0.1)), [8.5 / 16.0, 0.1, 0.1])
    some = TABLE.reachable(["TD90"])
    assert some.log_outcome_weights(0, True).tolist() == TABLE.log_outcome_weights(1, True).tolist()
    given = GraspTable.of_probabilities(["G"], [[0.25, 1.0]], 2)
    with np.errstate(divide="ignore"):
        np.testing.assert_allclose(given.log_outcome_weights(0, False, 3, 1), np.log([0.75, 0.0]))


def test_reachable_grasps_must_exist() -> None:
    with pytest.raises(UnknownName, match="there is no grasp 'X'; there are: 'TD0', 'TD90', 'OI90'"):
        TABLE.reachable(["X"])
    with pytest.raises(InvalidInput, match="grasp: expected at least one, got none"):
        TABLE.reachable([])


def test_expected_scores_by_hand() -> None:
    belief = np.array([0.5, 0.25, 0.25])
    np.testing.assert_allclose(TABLE.expected_scores(belief), [2.25 / 15, 4 / 15, 6.75 / 15])
    choice = best_grasp(TABLE, belief)
    assert choice.index == 2
    assert choice.expected_score == pytest.approx(6.75 / 15)


@pytest.mark.parametrize(
    ("expected", "index"),
    [
        ([0.2, 0.7, 0.7], 1),
        ([0.7 - 5e-13, 0.7, 0.1], 0),
        ([0.7 - 2e-12, 0.7, 0.1], 1),
        ([0.0, 1e-300, 0.0], 0),
        ([0.0, 1e-9, 0.0], 1),
    ],
)
def test_the_first_listed_within_1e_12_of_the_best_is_chosen(expected: list[float], index: int) -> None:
    choice = choose(np.array(expected))
    assert choice.index == index
    assert choice.expected_score == max(expected)


def test_no_grasp_is_chosen_where_every_grasp_scores_0() -> None:
    assert choose(np.zeros(3)) == Choice(None, 0.0)


def test_grasps_are_ranked_best_first_and_equals_as_listed() -> None:
    assert ranked(np.array([0.1, 0.5, 0.5 + 1e-13, 0.9, 0.1])) == [3, 1, 2, 0, 4]
    many = np.array([0.1, 0.9, 0.5] * 100)
    assert ranked(many) == [*range(1, 300, 3), *range(2, 300, 3), *range(0, 300, 3)]


def test_an_outcome_weighs_by_the_score_or_what_is_missing_to_1() -> None:
    scores = np.array([0.0, 0.25, 1.0])
    np.testing.assert_allclose(log_outcome_weights(scores, True), [-math.inf, math.log(0.25), 0.0])
    np.testing.assert_allclose(log_outcome_weights(scores, False), [0.0, math.log(0.75), -math.inf])


def test_a_score_floor_keeps_0_and_1_from_ruling_poses_out() -> None:
    scores = np.array([0.0, 0.25, 1.0])
    np.testing.assert_allclose(np.exp(log_outcome_weights(scores, True, 0.02)), [0.02, 0.25, 0.98])
    np.testing.assert_allclose(np.exp(log_outcome_weights(scores, False, 0.02)), [0.98, 0.75, 0.02])
    np.testing.assert_allclose(np.exp(log_outcome_weights(scores, True, 0.5)), [0.5] * 3)


@pytest.mark.parametrize("floor", [-0.01, 0.51, math.nan])
def test_a_score_floor_that_is_none_is_refused(floor: float) -> None:
    with pytest.raises(InvalidInput, match=r"score_floor: expected a number from 0 to 0\.5"):
        log_outcome_weights(np.array([0.5]), True, floor)
