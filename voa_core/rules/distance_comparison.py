"""Comparison of scans with displaced copies of poses for rules whose statistic is a sum of simple differences."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copy_kernels import differences_of_copies, differences_of_pairs
from voa_core.displaced_scans import DisplacedScans
from voa_core.kernels import Array

_NUMBERS_AT_ONCE = 2**18  # differences of a few poses, which stay in the cache of a processor core
_CHECK_EVERY = 64
SQUARES = -1.0
"""Margin that stands for squared differences, see `copy_kernels`."""


class RuleOfDifferences(Protocol):
    """An update rule whose statistic is a sum of squared differences of coded ranges, or of those beyond a margin."""

    @property
    def no_return_m(self) -> float:
        """Range that stands for a no-return, and upper limit of every return; metres."""

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Natural logarithms of the weights, in the shape of `statistic`."""

    def log_means(self, statistic: Floats, beams: NDArray[np.intp]) -> Floats:
        """Logarithms (N,) of the mean weight of J copies, from statistics (J, N) over `beams` (N,) beams."""


class DifferenceComparison:
    """Comparison of N scans with the displaced copies of k poses; nothing is left out."""

    leaves_out = False

    def __init__(
        self, rule: RuleOfDifferences, observed: Floats, copies: DisplacedScans, margin_m: float = SQUARES
    ) -> None:
        """Prepare the comparison of classified scans (N, r); with a margin in metres, beams beyond it count."""
        self._rule, self._copies, self._margin_m = rule, copies, margin_m
        self._observed = np.minimum(observed, rule.no_return_m)  # NaN stays
        self._predicted = np.minimum(copies.ranges, rule.no_return_m)
        self._compared = np.count_nonzero(~np.isnan(observed), axis=1)

    def log_weights(self, scans: NDArray[np.intp], poses: NDArray[np.intp]) -> Floats:
        """Logarithms ln w of the weights of every copy, (P, J), for P pairs of a scan and a pose."""
        statistics = np.zeros((len(scans), self._copies.copies))
        differences_of_pairs(
            self._observed,
            scans,
            poses,
            self._copies.start,
            self._copies.beams,
            self._predicted,
            self._rule.no_return_m,
            self._margin_m,
            statistics,
        )
        counts = self._compared[scans]
        for count in np.unique(counts):
            rows = counts == count
            statistics[rows] = self._rule.log_weights(statistics[rows], int(count)) if count > 0 else 0.0
        return statistics

    def log_means(self, _own: NDArray[np.intp], _least: Floats, check: Callable[[], None]) -> Floats:
        """Logarithms of the mean weight over the copies of each pose after each scan, (k, N)."""
        by_beam = np.ascontiguousarray(self._observed.T)
        copies, scans = self._copies.copies, by_beam.shape[1]
        at_once = max(1, _NUMBERS_AT_ONCE // (copies * scans))
        means, statistics = np.zeros((len(self._copies), scans)), np.zeros((at_once, copies, scans))
        beams = np.maximum(self._compared, 1)
        for number, first in enumerate(range(0, len(means), at_once)):
            if number % _CHECK_EVERY == 0:
                check()
            start = self._copies.start[first : first + at_once + 1]
            differences_of_copies(
                by_beam,
                start,
                self._copies.beams,
                self._predicted,
                self._rule.no_return_m,
                self._margin_m,
                statistics[: len(start) - 1],
            )
            for index in range(len(start) - 1):
                means[first + index] = self._rule.log_means(statistics[index], beams)
        return means
