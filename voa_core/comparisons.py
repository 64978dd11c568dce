"""Comparison of measured scans with the displaced copies of poses under an update rule.

A rule may bring a comparison of its own, which runs in loops made for it (`ComparesCopies`); of any other
rule the statistic of each scan and each copy is computed.
"""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copy_kernels import differences_of_pairs
from voa_core.displaced_scans import DisplacedScans
from voa_core.rules.distances import coded
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN

Indices = NDArray[np.intp]


class Comparison(Protocol):
    """Comparison of N scans with the J displaced copies of each of k poses."""

    @property
    def leaves_out(self) -> bool:
        """True if `log_means` may leave out copies whose weights are too small to matter."""

    def log_weights(self, scans: Indices, poses: Indices) -> Floats:
        """Logarithms ln w of the weights of every copy, (P, J), for P pairs of a scan and a pose."""

    def log_means(self, own: Indices, least: Floats, check: Callable[[], None]) -> Floats:
        """Logarithms of the mean weight over the copies of each pose after each scan, (k, N).

        Args:
            own: (N,) index of the pose that gives each scan, of which nothing is left out; -1: it is none of these.
            least: (N,) log weight; copies with less may be left out, and where all are, the result is -inf.
            check: called between blocks; an error that it raises ends the computation.
        """


@runtime_checkable
class ComparesCopies(Protocol):
    """An update rule with a comparison of its own."""

    def comparison(self, observed: Floats, copies: DisplacedScans) -> Comparison | None:
        """Make the comparison of classified scans (N, r) with copies; None: the parameters do not allow it."""


def comparison_of(rule: UpdateRule, observed: Floats, copies: DisplacedScans) -> Comparison:
    """Make the comparison of classified scans (N, r), metres, with displaced copies of poses under a rule."""
    own = rule.comparison(observed, copies) if copies.copies > 1 and isinstance(rule, ComparesCopies) else None
    return PlainComparison(rule, observed, copies) if own is None else own


class PlainComparison:
    """Comparison by the `statistic` of any rule."""

    leaves_out = False

    def __init__(self, rule: UpdateRule, observed: Floats, copies: DisplacedScans) -> None:
        """Prepare the comparison of classified scans (N, r) with displaced copies of poses."""
        self._rule, self._observed, self._copies = rule, observed, copies
        self._prediction = copies.prediction()

    def log_weights(self, scans: Indices, poses: Indices) -> Floats:
        """Logarithms ln w of the weights of every copy, (P, J), for P pairs of a scan and a pose."""
        rows, of_scan = np.unique(scans, return_inverse=True)
        some, of_pose = np.unique(poses, return_inverse=True)
        copies = self._copies.copies
        predicted = self._prediction.ranges.reshape(len(self._copies), copies, -1)[some]
        logs = self._every(self._observed[rows], predicted.reshape(len(some) * copies, -1))
        picked: Floats = logs.reshape(len(rows), len(some), copies)[of_scan, of_pose]
        return picked

    def log_means(self, _own: Indices, _least: Floats, check: Callable[[], None]) -> Floats:
        """Logarithms of the mean weight over the copies of each pose after each scan, (k, N)."""
        scans = np.arange(len(self._observed))
        means = np.zeros((len(self._copies), len(scans)))
        for pose in range(len(means)):
            check()
            logs = self.log_weights(scans, np.full(len(scans), pose))
            highest = logs.max(axis=1)
            shift = np.where(highest > -np.inf, highest, 0.0)
            with np.errstate(divide="ignore"):
                means[pose] = shift + np.log(np.exp(logs - shift[:, None]).mean(axis=1))
        return means

    def _every(self, observed: Floats, predicted: Floats) -> Floats:
        """Logarithms ln w for each scan (s, r) and each of the predicted ranges (m, c): (s, m).

        Scans with the same missing beams are compared at once.
        """
        columns, grid = self._prediction.columns, self._prediction.grid
        own = np.flatnonzero(np.isnan(observed).any(axis=0) | (observed < NO_RETURN).any(axis=0))
        every = np.union1d(own, columns)
        whole = np.full((len(predicted), len(every)), NO_RETURN)
        whole[:, np.searchsorted(every, columns)] = predicted
        # On every other beam all scans and all copies are no-returns: one comparison serves them all.
        rest = np.full((1, grid.beams - len(every)), NO_RETURN)
        constant = self._rule.statistic(rest, rest)[0, 0]
        seen = observed[:, every]
        lost = np.isnan(seen)
        missing, group = np.unique(lost, axis=0, return_inverse=True) if lost.any() else (lost[:1], np.zeros(len(lost)))
        result = np.zeros((len(observed), len(predicted)))
        for index, absent in enumerate(missing):
            rows = np.flatnonzero(group.reshape(-1) == index)
            compared = grid.beams - int(absent.sum())
            if compared == 0:
                continue
            statistic = self._rule.statistic(
                np.ascontiguousarray(seen[rows][:, ~absent]), np.ascontiguousarray(whole[:, ~absent])
            )
            result[rows] = self._rule.log_weights(statistic + constant, compared)
        return result


def squared_distances_of_pairs(
    observed: Floats, copies: DisplacedScans, no_return_m: float, scans: Indices, poses: Indices
) -> Floats:
    """Squared distances d^2 of pairs of a classified scan and a pose, to each copy of it, (P, J) square metres."""
    out = np.zeros((len(scans), copies.copies))
    ranges, predicted = coded(observed, no_return_m), coded(copies.ranges, no_return_m)
    differences_of_pairs(ranges, scans, poses, copies.start, copies.beams, predicted, no_return_m, -1.0, out)
    return out
