"""Choices after many scans are those of the plain formula, whatever the numbers of scans, poses and grasps."""

from typing import Any

import numpy as np
import pytest

from voa_core.checks import Floats
from voa_core.choices import Choices, choices_after
from voa_core.kernels import Array
from voa_core.panels import Panels
from voa_core.register_products import ROWS

GRASPS, POSES, SCANS = 40, 130, 200  # of each, more than one block of numbers holds
SIZES = [(1, 1, 1), (5, 63, 31), (6, 64, 32), (7, 65, 33), (12, 1, 64), (40, 130, 65), (3, 200, 129)]
"""Grasps, poses and scans: a block holds 6 grasps with the normaliser, 64 poses, and 32 or 64 scans."""
TYPES = [np.float64, np.float32]
TOLERANCE = {np.float64: 1e-13, np.float32: 1e-5}


def world(seed: int, grasps: int = GRASPS, poses: int = POSES, scans: int = SCANS) -> tuple[Floats, Floats, Floats]:
    """Weights over many orders of magnitude, scores and a belief."""
    random = np.random.default_rng(seed)
    weights = np.exp(-random.uniform(0.0, 40.0, (scans, poses)))
    return weights, random.random((grasps, poses)), random.dirichlet(np.full(poses, 0.3))


def blocks_of(scores: Floats, belief: Floats, dtype: type[np.floating]) -> Array:
    """Weighted scores and, after them, the belief, in blocks (g, c, ROWS)."""
    weighted = np.vstack([belief * scores, belief])
    padded = np.vstack([weighted, np.zeros((-len(weighted) % ROWS, len(belief)))])
    return np.ascontiguousarray(padded.reshape(-1, ROWS, len(belief)).transpose(0, 2, 1), dtype=dtype)


def chosen(weights: Array, scores: Floats, belief: Floats) -> Choices:
    """Choices from weights scan by scan, which must be those from weights in panels."""
    blocks = blocks_of(scores, belief, weights.dtype.type)
    by_rows = choices_after(weights, blocks, len(scores))
    for one, other in zip(by_rows, choices_after(Panels.of(weights), blocks, len(scores)), strict=True):
        np.testing.assert_array_equal(one, other)
    return by_rows


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize(("grasps", "poses", "scans"), SIZES)
def test_choices_are_those_of_the_formula(grasps: int, poses: int, scans: int, dtype: Any) -> None:
    weights, scores, belief = world(grasps, grasps, poses, scans)
    weights = weights.astype(dtype)
    choices = chosen(weights, scores, belief)
    norms = weights.astype(np.float64) @ belief
    expected = weights.astype(np.float64) @ (belief * scores).T / norms[:, None]
    assert choices.norms.dtype == dtype
    assert choices.norms == pytest.approx(norms, rel=TOLERANCE[dtype])
    assert choices.scores == pytest.approx(expected.max(axis=1), rel=TOLERANCE[dtype])
    lacking = choices.scores - expected[np.arange(scans), choices.chosen]
    assert np.abs(lacking).max() <= TOLERANCE[dtype]
    assert not choices.undecided[choices.chosen == expected.argmax(axis=1)].all() or scans == 1


@pytest.mark.parametrize("transposed", [False, True])
def test_weights_may_lie_in_memory_in_any_order(transposed: bool) -> None:
    weights, scores, belief = world(6)
    other = np.asfortranarray(weights) if transposed else np.repeat(weights, 2, axis=1)[:, ::2]
    for one, two in zip(chosen(weights, scores, belief), chosen(other, scores, belief), strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("difference", [1e-5, 1e-7, 1e-9, 2e-12])
def test_float64_distinguishes_grasps_that_hardly_differ(difference: float) -> None:
    weights, scores, belief = world(1)
    scores *= 0.9
    scores[7], scores[23] = 0.95, 0.95 + difference
    choices = chosen(weights, scores, belief)
    assert set(choices.chosen.tolist()) == {23}
    assert not choices.undecided.any()


def test_float32_says_which_choices_it_leaves_open() -> None:
    weights, scores, belief = world(1)
    scores *= 0.9
    scores[23], weights = 0.95, weights.astype(np.float32)
    assert not chosen(weights, scores, belief).undecided.any()
    scores[7] = 0.95 + 1e-7
    choices = chosen(weights, scores, belief)
    assert choices.undecided.all()
    assert set(choices.chosen.tolist()) == {7}


@pytest.mark.parametrize("dtype", TYPES)
def test_of_equal_grasps_the_first_listed_is_chosen(dtype: Any) -> None:
    weights, scores, belief = world(2)
    choices = chosen(weights.astype(dtype), np.vstack([scores, scores, scores]), belief)
    assert choices.chosen.max() < GRASPS


def test_weights_that_float32_would_lose_are_kept() -> None:
    weights, scores, belief = world(3)
    plain = chosen(weights, scores, belief)
    weights[::3] *= 1e-60
    weights[5] = 0.0
    choices = chosen(weights, scores, belief)
    others = np.arange(SCANS) != 5
    assert choices.chosen[others].tolist() == plain.chosen[others].tolist()
    assert choices.scores[others] == pytest.approx(plain.scores[others], rel=1e-13)
    assert (choices.chosen[5], choices.scores[5], choices.norms[5], choices.undecided[5]) == (-1, 0.0, 0.0, True)


@pytest.mark.parametrize("dtype", TYPES)
def test_no_grasp_is_chosen_where_none_succeeds(dtype: Any) -> None:
    weights, scores, belief = world(4)
    scores[:, :10] = 0.0
    weights[::4, 10:] = 0.0
    choices = chosen(weights.astype(dtype), scores, belief)
    assert set(choices.chosen[::4].tolist()) == {-1}
    assert not choices.scores[::4].any()
    assert choices.undecided[::4].all()
    assert (choices.chosen[1::4] >= 0).all()


def test_no_scans_give_no_choices() -> None:
    weights, scores, belief = world(5, scans=0)
    assert [len(each) for each in chosen(weights, scores, belief)] == [0, 0, 0, 0]
