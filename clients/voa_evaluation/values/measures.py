"""Measures of agreement between promised and achieved values of places: rank correlation and partial order."""

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_evaluation.statistics import rank_correlation
from voa_evaluation.values.truth import Truth

_SURE = 1.959964
_TIE = 1e-9
RESAMPLES = 10
"""Number of times that the scans of a case are drawn again for the oracle's rank correlation."""


@dataclass(frozen=True)
class Order:
    """Pairs of places whose achieved values surely differ.

    Attributes:
        alike: number of them that a promise puts in the same order; a tie counts one half.
        sure: their number.
        pairs: number of all pairs.
    """

    alike: float
    sure: int
    pairs: int


def order_agreement(promised: Floats, truth: Truth) -> Order:
    """Compare the order of promised net values (k,) with that of the achieved ones, over pairs that surely differ.

    A pair surely differs if its paired difference over the same samples exceeds 1.96 standard errors (partial-order
    agreement with confidence, Goshen and Keren, CoRL 2025).
    """
    achieved, covariance = truth.net, truth.covariance()
    first, second = np.triu_indices(len(achieved), 1)
    difference = achieved[first] - achieved[second]
    variance = covariance[first, first] + covariance[second, second] - 2.0 * covariance[first, second]
    sure = np.abs(difference) > _SURE * np.sqrt(np.maximum(variance, 0.0)) + _TIE
    promise = promised[first] - promised[second]
    alike = np.where(np.abs(promise) <= _TIE, 0.5, (np.sign(promise) == np.sign(difference)).astype(np.float64))
    return Order(float(alike[sure].sum()), int(sure.sum()), len(first))


def tau_of_promise(promised: Floats, truth: Truth) -> float | None:
    """Kendall's tau-b of promised (k,) and achieved net values; None where either has no order."""
    return rank_correlation(np.round(promised, 9), np.round(truth.net, 9))


def tau_of_oracle(truth: Truth, rng: np.random.Generator) -> float | None:
    """Kendall's tau-b that the true values would reach against achieved values over as many scans, on average.

    The achieved values stand for the true ones, and the scans are drawn again with replacement.
    """
    own = np.round(truth.net, 9)
    taus = [rank_correlation(own, np.round(again, 9)) for again in truth.resampled(rng, RESAMPLES)]
    known = [tau for tau in taus if tau is not None]
    return float(np.mean(known)) if known else None
