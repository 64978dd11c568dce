"""Samples of the poses, over which an expectation is taken where there are too many poses for all of them.

A systematic sample: the poses stand in an order along which the value to be averaged changes slowly, and each of as
many stretches of equal probability as the sample has room for gives one pose, drawn at random within the stretch.
Poses with more probability than a stretch are in every sample, with their own probability. The weighted mean over the
sample is unbiased (Horvitz and Thompson 1952); its error comes from differences within the stretches alone, and is
estimated from those between neighbours (Wolter, "Introduction to Variance Estimation", 2007, section 8.2).
"""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, number
from voa_core.grasps import GraspTable

_SCORE_STEP = 0.1


@dataclass(frozen=True, eq=False)
class PoseSample:
    """Sample of k of n poses with the share of each in an expectation.

    Attributes:
        poses: (k,) indices, those that are in every sample first, the others along the order of the sample. A pose at
            the border of two stretches may stand in it twice.
        shares: (k,) weights, which sum to 1.
        probabilities: (k,) of these poses under the belief that was sampled.
        spreads: (k,) variance of a value drawn from the stretch of each pose, in units of the variance of the values of
            its poses; 0 for a pose that is in every sample.
    """

    poses: NDArray[np.intp]
    shares: Floats
    probabilities: Floats
    spreads: Floats

    def __len__(self) -> int:
        return len(self.poses)

    @classmethod
    def of(cls, belief: Floats, order: NDArray[np.intp], size: int, seed: str) -> "PoseSample":
        """Draw a sample.

        Args:
            belief: (n,) probabilities of the poses.
            order: (n,) indices of all poses, neighbours with values that hardly differ.
            size: number k of poses to draw; with at least as many as are possible, the sample has all of them.
            seed: names the sample: equal arguments give equal samples.

        Raises:
            InvalidInput: the size is less than 1.
        """
        number("size", size, at_least=1.0)
        certain = _certain(belief, size)
        always, rest = order[certain[order]], order[~certain[order] & (belief[order] > 0.0)]
        strata = size - len(always) if len(rest) > 0 else 0
        drawn, stretch, spreads = _drawn(belief[rest], strata, _generator(seed, size))
        poses = np.concatenate([always, rest[drawn]])
        shares = np.concatenate([belief[always], np.full(strata, stretch)])
        return cls(poses, shares / shares.sum(), belief[poses], np.concatenate([np.zeros(len(always)), spreads]))

    def over(self, n: int) -> Floats:
        """Weights of all n poses in the expectation, (n,): 0 for a pose that is not in the sample."""
        weights = np.zeros(n)
        np.add.at(weights, self.poses, self.shares)
        return weights

    @property
    def cell_weights(self) -> Floats:
        """Weights (k,) whose squares sum, over sampled poses, to an estimate of the sum of squares over all poses."""
        weights: Floats = np.sqrt(self.shares * self.probabilities)
        return weights

    def standard_error(self, values: Floats) -> float:
        """Standard error of the mean of values (k,) of the sampled poses, weighted by their shares."""
        drawn = self.spreads > 0.0
        values, scales = values[drawn], self.shares[drawn] ** 2 * self.spreads[drawn]
        if len(values) == 0:
            return 0.0
        return float(np.sqrt(np.sum(scales * _local_variances(values))))


def order_by_best_score(table: GraspTable, belief: Floats) -> NDArray[np.intp]:
    """Order the poses by the score of their best grasp, in steps of 0.1, and then by probability: (n,) indices.

    An informative look gains most at a pose whose best grasp is good. Among such poses it gains more at a probable one,
    for the belief after the look holds that to be the true one sooner.
    """
    return np.lexsort((belief, np.round(table.scores.max(axis=0) / _SCORE_STEP)))


def _certain(belief: Floats, size: int) -> NDArray[np.bool_]:
    """Flags (n,) of the poses that are in every sample: no stretch of the rest has as much probability as they."""
    certain = np.zeros(len(belief), dtype=bool)
    if size >= np.count_nonzero(belief):
        return belief > 0.0
    while True:
        rest = belief[~certain].sum()
        more = ~certain & (belief * (size - np.count_nonzero(certain)) >= rest) & (belief > 0.0)
        if not more.any():
            return certain
        certain |= more


def _drawn(belief: Floats, strata: int, random: np.random.Generator) -> tuple[NDArray[np.intp], float, Floats]:
    """Draw one of the poses in each of some stretches of equal probability.

    Args:
        belief: (n,) probabilities of the poses, in order.
        strata: number s of stretches.
        random: source of the draws.

    Returns:
        Indices (s,) of the poses, the probability of a stretch, and the spread of each stretch, (s,), which is
        1 - sum_j f_j^2 with f_j the shares of its poses.
    """
    if strata == 0:
        return np.zeros(0, dtype=np.intp), 0.0, np.zeros(0)
    ends = np.cumsum(belief)
    stretch = float(ends[-1]) / strata
    borders = stretch * np.arange(1, strata)
    points = stretch * (np.arange(strata) + random.uniform(size=strata))
    drawn = np.minimum(np.searchsorted(ends, points, side="right"), len(belief) - 1)
    cuts = np.sort(np.concatenate([[0.0], ends, borders]))
    lengths, middles = np.diff(cuts) / stretch, 0.5 * (cuts[1:] + cuts[:-1])
    of_piece = np.searchsorted(borders, middles, side="right")
    squares = np.bincount(of_piece, weights=lengths**2, minlength=strata)
    return drawn, stretch, np.maximum(1.0 - squares, np.finfo(float).tiny)


def _local_variances(values: Floats) -> Floats:
    """Variance about each of the values (k,) from its differences to its neighbours: half their mean square."""
    if len(values) == 1:
        return values**2
    squares = 0.5 * np.diff(values) ** 2
    ends = np.concatenate([squares[:1], squares, squares[-1:]])
    variances: Floats = 0.5 * (ends[1:] + ends[:-1])
    return variances


def _generator(seed: str, size: int) -> np.random.Generator:
    digest = hashlib.sha256(f"poses\n{size}\n{seed}".encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:16], "big"))
