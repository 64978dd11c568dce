"""Standard errors of values: from the number of simulated scans, and from the attempts behind the grasp scores."""

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.grasps import GraspTable
from voa_core.jit import kernel


def standard_error(shares: Floats, gains: Floats) -> float:
    """Standard error of the mean gain of a look over simulated scans.

    Its square is sum_p s[p]^2 Var_k / K, with the variance over the K scans of a pose. With one scan of each pose it is
    sum_p s[p]^2 (g_p - mean g)^2, with the mean weighted by s: the poses stand for each other's scans.

    K scans that agree do not show that all scans do: a look that fails once in a thousand scans would have no error at
    all. So, as in Laplace's rule of succession, the variance counts one scan more over all poses, after which nothing
    is gained: s[p] of it at pose p. A look that never gains anything keeps the error 0.

    Args:
        shares: (k,) probabilities s[p] of the poses.
        gains: (k, K) gain after each scan of each pose.
    """
    samples = gains.shape[1]
    if samples == 1:
        total = shares.sum()
        mean = float(shares @ gains[:, 0]) / (total if total > 0.0 else 1.0)
        return float(np.sqrt(np.sum((shares * (gains[:, 0] - mean)) ** 2)))
    means = gains.sum(axis=1) / (samples + shares)
    squares = np.sum((gains - means[:, None]) ** 2, axis=1) + shares * means**2
    return float(np.sqrt(np.sum(shares**2 * squares / (samples - 1 + shares)) / samples))


def score_standard_error(
    table: GraspTable,
    chosen: NDArray[np.intp],
    kept: NDArray[np.intp],
    poses: NDArray[np.intp],
    shares: Floats,
) -> float | None:
    """Standard deviation of a VOA whose grasps stay chosen while the true scores vary about the measured ones.

    The executed value is linear in the scores: each cell counts by how much oftener the look has its grasp chosen at
    its pose. So no scores need be drawn.

    Args:
        table: the grasps; None is returned where its scores are given probabilities.
        chosen, kept: (k,) grasp after each scan with the look and without it; -1 for none.
        poses: (k,) pose that gives the scan; the scans of a pose are neighbours.
        shares: (k,) probability of the scan.
    """
    variances = table.score_variances
    if variances is None:
        return None
    return float(np.sqrt(variance_of_gain(chosen, kept, poses, shares, variances)))


@kernel
def variance_of_gain(
    chosen: NDArray[np.intp], kept: NDArray[np.intp], poses: NDArray[np.intp], shares: Floats, variances: Floats
) -> float:
    """Variance of the gain of a look, from the variances (m, n) of the scores; see `score_standard_error`."""
    oftener, total, first = np.zeros(len(variances)), 0.0, 0
    while first < len(poses):
        last = first
        while last < len(poses) and poses[last] == poses[first]:
            if chosen[last] >= 0:
                oftener[chosen[last]] += shares[last]
            if kept[last] >= 0:
                oftener[kept[last]] -= shares[last]
            last += 1
        for scan in range(first, last):
            for grasp in (chosen[scan], kept[scan]):
                if grasp >= 0:
                    total += oftener[grasp] ** 2 * variances[grasp, poses[first]]
                    oftener[grasp] = 0.0
        first = last
    return total
