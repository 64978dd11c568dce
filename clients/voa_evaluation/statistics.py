"""Means and ratios with bootstrap intervals, and rank correlation."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import kendalltau

from voa_client.formatting import signed
from voa_fleet.world.frames import Floats

RESAMPLES = 2000
_DIGITS = 12
"""Decimal digits in which two values differ that are not tied: means of equal counts in another order may not."""
_LOW, _HIGH = 2.5, 97.5


@dataclass(frozen=True)
class Interval:
    """A figure with its 95 % bootstrap interval.

    Attributes:
        value: over the observations.
        low, high: ends of the interval.
        count: number of observations.
    """

    value: float
    low: float
    high: float
    count: int

    @property
    def excludes_zero(self) -> bool:
        """True if zero lies outside of the interval."""
        return self.low > 0.0 or self.high < 0.0


def interval_text(interval: Interval | None) -> str:
    """Write a difference with its interval; a dash for None."""
    if interval is None:
        return "-"
    return f"{signed(interval.value)} [{signed(interval.low)}, {signed(interval.high)}]"


def bootstrap_mean(strata: Sequence[Floats], seed: int, resamples: int = RESAMPLES) -> Interval:
    """Compute the mean of all observations, with resampling within each stratum (B. Efron, 1979; percentile interval).

    Give paired differences as differences, so that what two policies share cancels.

    Args:
        strata: observations, one array (n_s,) per stratum, here per object; empty ones are left out.
        seed: of the resampling.
        resamples: their number.

    Raises:
        ValueError: there is no observation.
    """
    full = [np.asarray(stratum, dtype=np.float64) for stratum in strata if len(stratum)]
    count = sum(len(stratum) for stratum in full)
    if count == 0:
        raise ValueError("expected at least one observation, got none")
    rng = np.random.default_rng(seed)
    sums = np.zeros(resamples)
    for stratum in full:
        sums += stratum[rng.integers(0, len(stratum), (resamples, len(stratum)))].sum(axis=1)
    low, high = np.percentile(sums / count, [_LOW, _HIGH])
    return Interval(math.fsum(math.fsum(stratum) for stratum in full) / count, float(low), float(high), count)


def bootstrap_ratio(numerators: Floats, denominators: Floats, seed: int, resamples: int = RESAMPLES) -> Interval:
    """Compute the ratio of two sums (n,), resampled by row: a mean over clusters of `denominators` members each.

    Raises:
        ValueError: the denominators sum to 0.
    """
    total = float(denominators.sum())
    if total == 0.0:
        raise ValueError("expected at least one observation, got none")
    chosen = np.random.default_rng(seed).integers(0, len(numerators), (resamples, len(numerators)))
    over, under = numerators[chosen].sum(axis=1), denominators[chosen].sum(axis=1)
    low, high = np.percentile(over[under > 0.0] / under[under > 0.0], [_LOW, _HIGH])
    return Interval(float(numerators.sum()) / total, float(low), float(high), round(total))


def rank_correlation(first: Floats, second: Floats) -> float | None:
    """Compute Kendall's tau-b of two series (k,); None where one of them is constant, so that it has no order.

    Values that differ by a rounding error are tied.
    """
    first, second = np.round(first, _DIGITS), np.round(second, _DIGITS)
    if len(first) < 2 or np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return None
    return float(kendalltau(first, second).statistic)


def bootstrap_rank_correlation(
    beforehand: Floats, achieved: Floats, seed: int, resamples: int = RESAMPLES
) -> Interval | None:
    """Compute Kendall's tau-b between a value per column and the column means of observations, resampled by row.

    Args:
        beforehand: values, (k,).
        achieved: observations, (n, k), a row per drop.
        seed: of the resampling.
        resamples: their number; those with constant means are left out.

    Returns:
        None where the values or the means are constant, or the means of every resample are.
    """
    tau = rank_correlation(beforehand, achieved.mean(axis=0))
    if tau is None:
        return None
    chosen = np.random.default_rng(seed).integers(0, len(achieved), (resamples, len(achieved)))
    taus = _taus(beforehand, np.stack([achieved[rows].mean(axis=0) for rows in chosen]))
    known = taus[np.isfinite(taus)]
    if not len(known):
        return None
    low, high = np.percentile(known, [_LOW, _HIGH])
    return Interval(tau, float(low), float(high), len(achieved))


def _taus(first: Floats, rows: Floats) -> Floats:
    """Kendall's tau-b of `first` (k,) with every row of (b, k), (b,); NaN for constant rows."""
    left, right = np.triu_indices(len(first), 1)
    signs = np.sign(np.round(rows[:, left] - rows[:, right], _DIGITS))
    own = np.sign(np.round(first[left] - first[right], _DIGITS))
    untied: NDArray[np.float64] = np.sqrt(np.abs(own).sum() * np.abs(signs).sum(axis=1))
    taus: Floats = np.where(untied > 0.0, (signs @ own) / np.where(untied > 0.0, untied, 1.0), np.nan)
    return taus
