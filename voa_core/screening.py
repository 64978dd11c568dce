"""Choice of a grasp after each of many scans by products of matrices, in as little of float64 as it takes.

With B = [b * Q^T | b], column q of B^T W^T holds sum_p W[q, p] b[p] Q[x, p] for every grasp x, and the normaliser last.
Of many grasps in float64 all but the best need not be known so well. A product in float32, which takes half the time,
shows which grasp is the best after most scans, since its rounding errors are bounded; the score of that one grasp is
then computed in float64. Scans after which other grasps come near the best are multiplied in float64 throughout.

Weights over exact scans that are kept in float64 may be kept in float32 too: to round them takes a fifth of the time.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choice_kernels import choose_each, score_chosen
from voa_core.grasps import TIE
from voa_core.kernels import Array

_FLOAT64, _FLOAT32 = np.dtype(np.float64), np.dtype(np.float32)
_TIE: dict[np.dtype[Any], np.floating] = {_FLOAT64: np.float64(TIE), _FLOAT32: np.float32(1e-6)}
LEAST_NORM = {_FLOAT64: 1e-200, _FLOAT32: 1e-20}
"""Normalisers below which weights that count may have been lost, by type of the weights."""
_SCREEN_FROM = 16  # grasps; with fewer a product in float64 costs no more than a second look at the weights
_ROUND_FROM = 32  # grasps; with fewer it costs no more than to round the weights before
_COLUMNS = 64  # that are written at once: so many rows of weights stay in a cache
_ROWS = 512  # scans at once: with fewer the product is slower, more would not stay in a cache between two looks at them
_FUTILE = 0.5  # share of scans that float32 leaves open, from which screening the others would not pay
_UNIT = 2.0**-24  # largest relative error of one rounding to float32


class Choices(NamedTuple):
    """Grasps that are best after k scans.

    Attributes:
        chosen: (k,) index of the first listed that is as good as the best; -1 where the best scores 0.
        scores: (k,) expected score of the best, 0 where nothing is left of the normaliser.
        norms: (k,) normaliser, sum_p w[p] b[p].
        undecided: (k,) True where rounding or underflow may have decided: no score is left, or in float32 the best
            score does not differ from the next.
    """

    chosen: NDArray[np.intp]
    scores: Floats
    norms: Array
    undecided: NDArray[np.bool_]


def rough_scores(weighted_scores: Array) -> Array | None:
    """Round weighted scores (m + 1, c) to float32 where screening by them pays; None where it does not."""
    if weighted_scores.dtype == _FLOAT32 or len(weighted_scores) <= _SCREEN_FROM:
        return None
    return weighted_scores.astype(np.float32)


def rough_weights(matrix: Floats) -> Array:
    """Round weights (k, n) to float32, to screen by; column by column in memory, as kept weights in float32 are."""
    columns = np.zeros(matrix.shape[::-1], dtype=np.float32)
    for start in range(0, len(matrix), _COLUMNS):
        columns[:, start : start + _COLUMNS] = matrix[start : start + _COLUMNS].T
    return columns.T


def choices_after(weights: Array, weighted_scores: Array, rough: Array | None, rounded: Array | None = None) -> Choices:
    """Choose the best grasp after each of k scans.

    Args:
        weights: (k, c) weights of the poses after each scan, float64 or float32.
        weighted_scores: (m + 1, c) probability times score of each grasp, and the probabilities last; of the same type.
        rough: (m + 1, c) the weighted scores in float32 to screen the grasps by; None to multiply all as they are.
        rounded: (k, c) the weights in float32, where they are known.
    """
    if rough is None or (rounded is None and len(weighted_scores) <= _ROUND_FROM):
        return _by_one_product(weights, weighted_scores)
    parts: list[Choices] = []
    for start in range(0, len(weights), _ROWS):
        some = weights[start : start + _ROWS]
        known = some.astype(np.float32) if rounded is None else rounded[start : start + _ROWS]
        part, left_open = _screened(some, known, weighted_scores, rough)
        parts.append(part)
        if left_open > _FUTILE and start + _ROWS < len(weights):
            parts.append(_by_one_product(weights[start + _ROWS :], weighted_scores))
            break
    return parts[0] if len(parts) == 1 else Choices(*map(np.concatenate, zip(*parts, strict=True)))


def _by_one_product(weights: Array, weighted_scores: Array) -> Choices:
    product = weighted_scores @ weights.T
    choices, close = _choices_of(product, _TIE[product.dtype])
    if product.dtype == _FLOAT32:
        choices.undecided[close] = True
    return choices


def _screened(weights: Floats, rounded: Array, weighted_scores: Floats, rough: Array) -> tuple[Choices, float]:
    """Choose by a product in float32 and, where it leaves the choice open, by one in float64.

    Args:
        weights: (k, c) weights of the poses after each scan.
        rounded: (k, c) these in float32.
        weighted_scores: (m + 1, c) probability times score of each grasp, and the probabilities last.
        rough: (m + 1, c) the weighted scores in float32.

    Returns:
        The choices, and the share of scans that float32 left open.
    """
    product = rough @ rounded.T
    choices, close = _choices_of(product, _uncertainty(weights.shape[1]))
    some = np.flatnonzero(close | choices.undecided | (choices.norms < LEAST_NORM[_FLOAT32]))
    chosen, scores, undecided = choices.chosen, choices.scores, choices.undecided
    norms = np.zeros(len(weights))
    chosen[some] = 0
    score_chosen(weights, weighted_scores, chosen, scores, norms)
    if len(some):
        exact = _by_one_product(weights[some], weighted_scores)
        chosen[some], scores[some], norms[some], undecided[some] = exact
    return Choices(chosen, scores, norms, undecided), len(some) / len(weights)


def _uncertainty(terms: int) -> np.floating:
    """Share of the normaliser by which two sums in float32 may seem to differ, though in float64 they differ otherwise.

    A sum of c products w b Q of non-negative numbers, each factor rounded once, is off by at most c + 2 units of
    rounding of itself, so by as many of the normaliser. Each of two sums may be, and the comparison is rounded itself.
    """
    return np.float32(3.0 * (terms + 4) * _UNIT)


def _choices_of(product: Array, tie: np.floating) -> tuple[Choices, NDArray[np.bool_]]:
    """Choose for every column of (m + 1, k) unnormalised expected scores with the normaliser last.

    Returns:
        The choices, undecided where the best is no better than 0 by the share `tie` of the normaliser, and flags of the
        columns in which another grasp is as good as the best, (k,).
    """
    k = product.shape[1]
    choices = Choices(np.zeros(k, np.intp), np.zeros(k), product[-1], np.zeros(k, np.bool_))
    return choices, choose_each(product, tie, choices.chosen, choices.scores, choices.undecided)
