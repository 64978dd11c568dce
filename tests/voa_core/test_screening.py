"""Choices after many scans: a product in float32 that screens the grasps changes no choice that float64 would make."""

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.screening import Choices, choices_after, rough_scores, rough_weights

GRASPS, POSES, SCANS = 40, 30, 1_200  # more scans than are screened at once


def weighted(scores: Floats, belief: Floats) -> Floats:
    """Factor [b * Q^T | b]^T of the product, (m + 1, c)."""
    return np.vstack([belief * scores, belief])


def screened(weights: Floats, factor: Floats) -> Choices:
    """Choices with screening, of a table that is large enough for it; whether the weights are rounded before or not."""
    rough = rough_scores(factor)
    assert rough is not None
    choices = choices_after(weights, factor, rough)
    assert_same(choices_after(weights, factor, rough, rough_weights(weights)), choices)
    return choices


def test_with_few_grasps_only_weights_that_are_rounded_already_are_screened(monkeypatch: pytest.MonkeyPatch) -> None:
    weights, scores, belief = world(8, grasps=20)
    factor, rounded = weighted(scores, belief), rough_weights(weights)
    rough = rough_scores(factor)
    exact = choices_after(weights, factor, None)
    assert_same(choices_after(weights, factor, rough), exact)
    assert_same(choices_after(weights, factor, rough, rounded), exact)
    monkeypatch.setattr("voa_core.screening._screened", None)
    choices_after(weights, factor, rough)
    with pytest.raises(TypeError):
        choices_after(weights, factor, rough, rounded)


def world(seed: int, grasps: int = GRASPS) -> tuple[Floats, Floats, Floats]:
    """Weights over many orders of magnitude, scores and a belief."""
    random = np.random.default_rng(seed)
    weights = np.exp(-random.uniform(0.0, 40.0, (SCANS, POSES)))
    return weights, random.random((grasps, POSES)), random.dirichlet(np.full(POSES, 0.3))


def assert_same(screened: Choices, exact: Choices) -> None:
    """Choices that agree to the last digits of float64."""
    assert screened.chosen.tolist() == exact.chosen.tolist()
    assert screened.scores == pytest.approx(exact.scores, rel=1e-13, abs=1e-300)
    assert screened.norms == pytest.approx(exact.norms, rel=1e-13, abs=1e-300)
    assert screened.undecided.tolist() == exact.undecided.tolist()


@pytest.mark.parametrize("seed", range(5))
def test_screening_by_float32_changes_no_choice(seed: int) -> None:
    weights, scores, belief = world(seed)
    factor = weighted(scores, belief)
    assert_same(screened(weights, factor), choices_after(weights, factor, None))


@pytest.mark.parametrize("difference", [1e-5, 1e-7, 1e-9, 2e-12])
def test_grasps_that_float32_cannot_distinguish_are_distinguished(difference: float) -> None:
    weights, scores, belief = world(1)
    scores *= 0.9
    scores[7], scores[23] = 0.95, 0.95 + difference
    factor = weighted(scores, belief)
    choices = screened(weights, factor)
    assert set(choices.chosen.tolist()) == {23}
    assert_same(choices, choices_after(weights, factor, None))


def test_of_equal_grasps_the_first_listed_is_chosen() -> None:
    weights, scores, belief = world(2)
    factor = weighted(np.vstack([scores, scores, scores]), belief)
    choices = screened(weights, factor)
    assert choices.chosen.max() < GRASPS
    assert_same(choices, choices_after(weights, factor, None))


def test_weights_that_float32_loses_are_kept() -> None:
    weights, scores, belief = world(3)
    weights[::3] *= 1e-60
    weights[5] = 0.0
    factor = weighted(scores, belief)
    choices = screened(weights, factor)
    assert_same(choices, choices_after(weights, factor, None))
    assert (choices.chosen[5], choices.scores[5], choices.norms[5], choices.undecided[5]) == (-1, 0.0, 0.0, True)


def test_no_grasp_is_chosen_where_none_succeeds() -> None:
    weights, scores, belief = world(4)
    scores[:, :10] = 0.0
    weights[::4, 10:] = 0.0
    choices = screened(weights, weighted(scores, belief))
    assert set(choices.chosen[::4].tolist()) == {-1}
    assert not choices.scores[::4].any()
    assert_same(choices, choices_after(weights, weighted(scores, belief), None))


def test_few_grasps_and_float32_are_not_screened() -> None:
    _, scores, belief = world(5)
    assert rough_scores(weighted(scores[:15], belief)) is None
    assert rough_scores(weighted(scores[:16], belief)) is not None
    assert rough_scores(weighted(scores, belief).astype(np.float32)) is None


def test_rounded_weights_lie_column_by_column() -> None:
    weights, _, _ = world(7)
    rounded = rough_weights(weights)
    np.testing.assert_array_equal(rounded, weights.astype(np.float32))
    assert rounded.T.flags.c_contiguous


def test_the_best_score_is_the_largest_expected_score() -> None:
    weights, scores, belief = world(6)
    after = weights * belief
    expected = (after / after.sum(axis=1, keepdims=True)) @ scores.T
    choices = screened(weights, weighted(scores, belief))
    assert choices.scores == pytest.approx(expected.max(axis=1), rel=1e-13)
    assert choices.chosen.tolist() == expected.argmax(axis=1).tolist()
