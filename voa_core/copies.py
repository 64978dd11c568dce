"""Comparison of many simulated scans with the displaced copies of all poses, block by block."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.comparisons import comparison_of, squared_distances_of_pairs
from voa_core.displaced_scans import DisplacedScans
from voa_core.filtering import log_means
from voa_core.jit import kernel
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN
from voa_core.weights import wanted

_LARGEST_ERROR = 1e-7  # of a value of assistance, from copies that are left out
_PAIRS_AT_ONCE = 2**20  # pairs of a scan and a displaced copy, whose log weights take 8 MiB
_NO_SHARE = 40.0  # e^-40 of the largest weight of a pose's copies is below the rounding of their sum


@dataclass(frozen=True, eq=False)
class SimulatedScans:
    """Simulated scans of all poses at one place, classified.

    Attributes:
        columns: (c,) ascending indices of the beams on which some scan returns or is missing; every other beam is a
            no-return in every scan.
        ranges: (N, c) metres, inf for a no-return, NaN for a missing beam; all scans of a pose, then the next pose's.
        missing: (g, c) the different sets of missing beams.
        group: (N,) index of each scan's set of missing beams.
        compared: (N,) number of beams that are not missing.
    """

    columns: NDArray[np.intp]
    ranges: Floats
    missing: NDArray[np.bool_]
    group: NDArray[np.intp]
    compared: NDArray[np.intp]

    @classmethod
    def of(cls, columns: NDArray[np.intp], ranges: Floats, beams: int) -> "SimulatedScans":
        """Sort classified scans (N, c) on these columns, of so many beams in all, by their missing beams."""
        lost = np.isnan(ranges)
        if lost.any():
            missing, group = np.unique(lost, axis=0, return_inverse=True)
        else:
            missing, group = np.zeros((1, len(columns)), dtype=bool), np.zeros(len(ranges), dtype=np.intp)
        return cls(columns, frozen(ranges), missing, group.reshape(-1), beams - lost.sum(axis=1))

    def dense(self, beams: int) -> Floats:
        """Ranges of every one of so many beams, (N, beams) metres; inf for a no-return, NaN for a missing beam."""
        ranges = np.full((len(self.ranges), beams), NO_RETURN)
        ranges[:, self.columns] = self.ranges
        return ranges

    def part(self, rows: NDArray[np.intp]) -> "SimulatedScans":
        """Select the scans `rows`, in that order."""
        return SimulatedScans(self.columns, self.ranges[rows], self.missing, self.group[rows], self.compared[rows])


@dataclass(frozen=True, eq=False)
class Copies:
    """Predictions of all displaced copies of all poses at one place, in blocks of poses.

    Attributes:
        per_pose: number J of copies of each pose.
        blocks: gives the poses of each block, and the predictions of their copies.
        nbytes: memory held, in bytes.
    """

    per_pose: int
    blocks: Callable[[], Iterable[tuple[slice, DisplacedScans]]]
    nbytes: int


def negligible(poses: int) -> float:
    """Logarithm T of the factor by which a copy that is left out weighs less than the pose that gives the scan.

    Let scan i come from pose q, with weight w[i, q] there. Leaving out every copy of weight below e^-T w[i, q] takes at
    most e^-T w[i, q] from the total weight sum_p b[p] w[i, p], which is at least b[q] w[i, q]: a share of at most
    e^-T / b[q]. The scan counts in a value of assistance with b[q] / K, so its term changes by at most 2 e^-T / K, and
    the value by at most 2 n e^-T, which T keeps below 1e-7. Where a scan counts with another probability than its pose
    has, or with looks from other places, `choices.after_each` computes the row in full if that could matter.

    Args:
        poses: number n of poses.
    """
    return math.log(2.0 * max(poses, 500) / _LARGEST_ERROR)


def log_mean_weights(
    scans: Sequence[SimulatedScans],
    refused: Sequence[NDArray[np.bool_]],
    copies: Copies,
    rule: UpdateRule,
    log_sums: Floats | None,
    out: Floats,
    check: Callable[[], None] = wanted,
) -> None:
    """Compute ln w of every pose after the scans of every sample: the mean over its copies of the scans' weights.

    Args:
        scans: one or more scans in a row of each of the N samples.
        refused: (N,) for each of them, flags of the scans that count for nothing.
        copies: of the poses.
        rule: the update rule.
        log_sums: (n, J) log weights of earlier looks from the place, summed; None: there are none.
        out: (N, n) written: the logarithm of the mean after the scans divided by the mean before.
        check: called before each block of poses; an error that it raises ends the computation.
    """
    number = len(out)
    for poses, predicted in copies.blocks():
        compared = [comparison_of(rule, scan.dense(predicted.grid.beams), predicted) for scan in scans]
        before = np.zeros((len(predicted), copies.per_pose)) if log_sums is None else log_sums[poses]
        at_once = max(1, _PAIRS_AT_ONCE // (number * copies.per_pose))
        for first in range(0, len(predicted), at_once):
            check()
            some = np.arange(first, min(first + at_once, len(predicted)))
            pairs = np.tile(np.arange(number), len(some)), np.repeat(some, number)  # of a scan and a pose
            total = np.zeros((len(some), number, copies.per_pose))
            for comparison, ignored in zip(compared, refused, strict=True):
                weights = comparison.log_weights(*pairs).reshape(total.shape)
                weights[:, ignored] = 0.0
                total += weights
            part = np.zeros((number, len(some)))
            _log_mean(total, before[some], part)
            out[:, poses.start + first : poses.start + first + len(some)] = part


def log_mean_weights_of_each(
    scans: SimulatedScans,
    own: NDArray[np.intp],
    copies: Copies,
    rule: UpdateRule,
    out: Floats,
    check: Callable[[], None] = wanted,
) -> Floats | None:
    """Compute ln w of every pose after a single scan of each sample at a place that was not looked from.

    Copies that are negligible beside the pose that gives the scan are left out, see `negligible`.

    Args:
        scans: of the N samples.
        own: (N,) index of the pose that gives each scan.
        copies: of the poses.
        rule: the update rule.
        out: (N, n) written; -inf also where all copies of a pose are left out.
        check: called between blocks; an error that it raises ends the computation.

    Returns:
        ln w (N,) below which copies are left out; None: none are.
    """
    least = np.full(len(out), -np.inf)
    for poses, some in copies.blocks():
        check()
        mine = np.flatnonzero((own >= poses.start) & (own < poses.stop))
        comparison = comparison_of(rule, scans.part(mine).dense(some.grid.beams), some)
        if comparison.leaves_out and len(mine):
            means = log_means(comparison.log_weights(np.arange(len(mine)), own[mine] - poses.start))
            least[mine] = means - negligible(out.shape[1])
    leaves_out = True
    for poses, some in copies.blocks():  # predicted again where they are not kept: all together may not fit in memory
        comparison = comparison_of(rule, scans.dense(some.grid.beams), some)
        within = np.where((own >= poses.start) & (own < poses.stop), own - poses.start, -1)
        out[:, poses] = comparison.log_means(within, least, check).T
        leaves_out = leaves_out and comparison.leaves_out
    return least if leaves_out else None


def distances(scans: SimulatedScans, copies: Copies, no_return_m: float) -> Floats:
    """Distance d of each scan to each pose, at the copy that fits best, (N, n) metres."""
    number, parts = len(scans.ranges), []
    for _, predicted in copies.blocks():
        observed = scans.dense(predicted.grid.beams)
        part = np.zeros((number, len(predicted)))
        for pose in range(len(predicted)):
            pairs = np.arange(number), np.full(number, pose)
            part[:, pose] = squared_distances_of_pairs(observed, predicted, no_return_m, *pairs).min(axis=1)
        parts.append(np.sqrt(part))
    return np.concatenate(parts, axis=1)


@kernel
def _log_mean(log_weights: Floats, log_sums: Floats, out: Floats) -> None:
    """Logarithm of the mean weight of each pose's copies after a scan, less that before it.

    Args:
        log_weights: (k, N, J) of the scans.
        log_sums: (k, J) of earlier looks from the place.
        out: (N, k) written; -inf where the mean after the scan is 0.
    """
    k, copies = log_sums.shape
    for pose in range(k):
        highest = -np.inf
        for copy in range(copies):
            highest = max(highest, log_sums[pose, copy])
        before = 0.0
        for copy in range(copies):
            before += np.exp(log_sums[pose, copy] - highest) if highest > -np.inf else 1.0
        for scan in range(len(out)):
            row = log_weights[pose, scan]
            largest = -np.inf
            for copy in range(copies):
                largest = max(largest, row[copy] + log_sums[pose, copy])
            if largest == -np.inf:
                out[scan, pose] = -np.inf
                continue
            total = 0.0
            for copy in range(copies):
                below = row[copy] + log_sums[pose, copy] - largest
                if below > -_NO_SHARE:
                    total += np.exp(below)
            out[scan, pose] = (largest - highest) + np.log(total / before)
