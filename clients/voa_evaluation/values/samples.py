"""Samples of a gain, by case and by scan, so that sums, differences and ratios of gains have honest intervals.

Cases of one object share their scans. A mean over cases therefore varies with the cases that were drawn and with the
scans: its variance is the variance between cases over their number, plus that of the mean over the scans.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_evaluation.statistics import Interval

_TWO_SIDED = 1.959964
SHOWN = 2.8
"""Standard errors that a true difference must have to be shown as sure (95 %) in 80 % of such evaluations."""


@dataclass(frozen=True, eq=False)
class Sample:
    """A gain over the cases and the scans of one object.

    Attributes:
        cases: (c,) mean gain of each case.
        scans: (n, S) mean over the cases of the share of the pose times the gain, for each scan of each pose.
    """

    cases: Floats
    scans: Floats

    def __add__(self, other: "Sample") -> "Sample":
        return Sample(self.cases + other.cases, self.scans + other.scans)

    def __sub__(self, other: "Sample") -> "Sample":
        return Sample(self.cases - other.cases, self.scans - other.scans)

    def scaled(self, factor: float) -> "Sample":
        """Multiply by a number."""
        return Sample(self.cases * factor, self.scans * factor)

    @property
    def mean(self) -> float:
        """Mean over the cases."""
        return float(self.cases.mean())

    @property
    def variance(self) -> float:
        """Variance of the mean, from the choice of cases and of scans."""
        number, scans = len(self.cases), int(self.scans.shape[1])
        between = float(self.cases.var(ddof=1)) / number if number > 1 else 0.0
        over_scans = float(self.scans.var(axis=1, ddof=1).sum()) / scans
        return between + over_scans


class Gathering:
    """Gathers the gains of case after case into a `Sample`."""

    def __init__(self) -> None:
        self._cases: list[float] = []
        self._scans: Floats | None = None

    def add(self, shares: Floats, gains: Floats) -> None:
        """Add a case with the shares (n,) of the poses and the gain (n, S) of each scan."""
        weighted = shares[:, None] * gains
        self._cases.append(float(weighted.mean(axis=1).sum()))
        self._scans = weighted if self._scans is None else self._scans + weighted

    def sample(self) -> Sample:
        """Make the sample of all cases so far; raises ValueError if there is none."""
        if self._scans is None:
            raise ValueError("expected at least one case, got none")
        return Sample(np.array(self._cases), self._scans / len(self._cases))


def mean_of(samples: Sequence[Sample]) -> float:
    """Mean gain over objects, each with the same weight."""
    return float(np.mean([sample.mean for sample in samples]))


def standard_error_of(samples: Sequence[Sample]) -> float:
    """Standard error of the mean gain over objects."""
    return float(np.sqrt(sum(sample.variance for sample in samples))) / len(samples)


def interval_of(samples: Sequence[Sample]) -> Interval:
    """Mean gain over objects with its normal 95 % interval; `count` is the number of cases."""
    value, half = mean_of(samples), _TWO_SIDED * standard_error_of(samples)
    return Interval(value, value - half, value + half, sum(len(sample.cases) for sample in samples))


def ratio_of(over: Sequence[Sample], under: Sequence[Sample]) -> Interval | None:
    """Ratio of two mean gains over objects, with the interval of the delta method.

    None where the denominator is not surely above 0, so that the ratio could be anything.

    Args:
        over: a sample for each object.
        under: a sample for each object, of the same cases and scans.
    """
    denominator = mean_of(under)
    if denominator <= max(1e-9, _TWO_SIDED * standard_error_of(under)):
        return None
    ratio = mean_of(over) / denominator
    rest = [a - b.scaled(ratio) for a, b in zip(over, under, strict=True)]
    half = _TWO_SIDED * standard_error_of(rest) / denominator
    return Interval(ratio, ratio - half, ratio + half, sum(len(sample.cases) for sample in over))


def normal_interval(value: float, standard_error: float, count: int) -> Interval:
    """Interval of a mean with a known standard error."""
    half = _TWO_SIDED * standard_error
    return Interval(value, value - half, value + half, count)
