"""Loops over the scans of a look, compiled: which grasp is best after each, and how good it is."""

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel, sum_kernel
from voa_core.kernels import Array


@kernel
def choose_each(
    product: Array, tie: np.floating, chosen: NDArray[np.intp], scores: Floats, low: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Choose the best grasp of each of k beliefs, in loops that run in vector registers.

    Args:
        product: (m + 1, k) unnormalised expected scores, the normaliser last.
        tie: scores within this share of the normaliser are as good as the best; of the type of `product`.
        chosen: (k,) written: the first listed that is as good as the best; -1 where the best is 0.
        scores: (k,) written: expected score of the best, 0 where nothing is left of the normaliser.
        low: (k,) written: True where the best is no better than a score of 0.

    Returns:
        Flags (k,) of the beliefs under which another grasp is as good as the best.
    """
    m, k = len(product) - 1, len(chosen)
    best, second = product[0].copy(), np.full(k, -1.0, product.dtype)
    first = np.zeros(k, np.int32)  # as wide as float32, so that one register holds as many
    close = np.zeros(k, np.bool_)
    for x in range(1, m):
        row, index = product[x], np.int32(x)
        for j in range(k):
            score, before = row[j], best[j]
            less = score if score < before else before
            second[j] = less if less > second[j] else second[j]
            first[j] = index if score > before else first[j]
            best[j] = score if score > before else before
    for j in range(k):
        norm = product[m, j]
        margin = tie * norm
        enough = best[j] - margin
        low[j] = best[j] <= margin
        close[j] = second[j] >= enough
        scores[j] = np.float64(best[j]) / np.float64(norm) if norm > 0.0 else 0.0
        chosen[j] = first[j]
        if best[j] <= 0.0:
            chosen[j] = -1
        elif close[j]:
            x = 0
            while product[x, j] < enough:
                x += 1
            chosen[j] = x
    return close


@sum_kernel
def score_chosen(
    weights: Floats, weighted_scores: Floats, chosen: NDArray[np.intp], scores: Floats, norms: Floats
) -> None:
    """Compute the expected score of the grasp that is chosen after each of k scans.

    Args:
        weights: (k, c) weights of the poses after each scan.
        weighted_scores: (m + 1, c) probability times score of each grasp, and the probabilities last.
        chosen: (k,) grasps, each from 0 to m - 1.
        scores: (k,) written: sum_p w[p] b[p] Q[x, p] / sum_p w[p] b[p], 0 where the latter is 0.
        norms: (k,) written: sum_p w[p] b[p].
    """
    masses = weighted_scores[-1]
    for j in range(len(chosen)):
        row, scored = weights[j], weighted_scores[chosen[j]]
        norm = score = 0.0
        for p in range(len(masses)):
            norm += row[p] * masses[p]
            score += row[p] * scored[p]
        norms[j] = norm
        scores[j] = score / norm if norm > 0.0 else 0.0
