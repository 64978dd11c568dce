"""Comparison of many simulated scans with the displaced copies of all poses, block by block."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.jit import kernel
from voa_core.prediction import Prediction
from voa_core.rules.distances import squared_distance
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import NO_RETURN
from voa_core.weights import wanted

_NEGLIGIBLE = 40.0  # e^-40 of the largest weight of a pose's copies is below the rounding of their sum


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

    def part(self, rows: NDArray[np.intp]) -> "SimulatedScans":
        """Select the scans `rows`, in that order."""
        return SimulatedScans(self.columns, self.ranges[rows], self.missing, self.group[rows], self.compared[rows])


@dataclass(frozen=True, eq=False)
class Copies:
    """Predictions of all displaced copies of all poses at one place, in blocks of poses.

    Attributes:
        per_pose: number J of copies of each pose.
        blocks: gives the poses of each block, and the prediction of their copies, pose by pose.
        nbytes: memory held, in bytes.
    """

    per_pose: int
    blocks: Callable[[], Iterable[tuple[slice, Prediction]]]
    nbytes: int


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
        check: called before each block of poses.
    """
    for poses, prediction in copies.blocks():
        check()
        total = np.zeros((len(scans[0].ranges), len(prediction.ranges)))
        for scan, ignored in zip(scans, refused, strict=True):
            weights = _compare(scan, prediction, rule, rule.log_weights)
            weights[ignored] = 0.0
            total += weights
        before = np.zeros((poses.stop - poses.start, copies.per_pose)) if log_sums is None else log_sums[poses]
        part = np.zeros((len(total), len(before)))
        _log_mean(total, before, part)
        out[:, poses] = part


def distances(scans: SimulatedScans, copies: Copies, no_return_m: float) -> Floats:
    """Distance d of each scan to each pose, at the copy that fits best, (N, n) metres."""
    parts = []
    for poses, prediction in copies.blocks():
        square = _compare(scans, prediction, _Distance(no_return_m), lambda statistic, _beams: statistic)
        parts.append(np.sqrt(square.reshape(len(square), poses.stop - poses.start, copies.per_pose).min(axis=2)))
    return np.concatenate(parts, axis=1)


@dataclass(frozen=True)
class _Distance:
    """Statistic d^2 of two scans."""

    no_return_m: float

    def statistic(self, observed: Floats, predicted: Floats) -> Floats:
        square: Floats = squared_distance(observed, predicted, self.no_return_m)
        return square


def _compare(
    scans: SimulatedScans,
    prediction: Prediction,
    rule: "UpdateRule | _Distance",
    finish: Callable[[Floats, int], Floats],
) -> Floats:
    """Compare each of N scans with each of M predicted ones: `finish` of the statistic and of the compared beams.

    Scans with the same missing beams are compared at once.
    """
    columns = np.union1d(scans.columns, prediction.columns)
    observed = np.full((len(scans.ranges), len(columns)), NO_RETURN)
    own = np.searchsorted(columns, scans.columns)
    observed[:, own] = scans.ranges
    predicted = np.full((len(prediction.ranges), len(columns)), NO_RETURN)
    predicted[:, np.searchsorted(columns, prediction.columns)] = prediction.ranges
    result = np.zeros((len(observed), len(predicted)))
    # On every other beam all scans and all copies are no-returns: one comparison serves them all.
    rest = np.full((1, prediction.grid.beams - len(columns)), NO_RETURN)
    constant = rule.statistic(rest, rest)[0, 0]
    for group in np.unique(scans.group):
        rows = np.flatnonzero(scans.group == group)
        known = np.ones(len(columns), dtype=bool)
        known[own] = ~scans.missing[group]
        compared = int(scans.compared[rows[0]])
        if compared == 0:
            continue
        every = known.all()
        statistic = rule.statistic(
            observed if every and len(rows) == len(observed) else np.ascontiguousarray(observed[rows][:, known]),
            predicted if every else np.ascontiguousarray(predicted[:, known]),
        )
        result[rows] = finish(statistic + constant, compared)
    return result


@kernel
def _log_mean(log_weights: Floats, log_sums: Floats, out: Floats) -> None:
    """Logarithm of the mean weight of each pose's copies after a scan, less that before it.

    Args:
        log_weights: (N, k * J) of the scans.
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
            row = log_weights[scan, pose * copies : (pose + 1) * copies]
            largest = -np.inf
            for copy in range(copies):
                largest = max(largest, row[copy] + log_sums[pose, copy])
            if largest == -np.inf:
                out[scan, pose] = -np.inf
                continue
            total = 0.0
            for copy in range(copies):
                below = row[copy] + log_sums[pose, copy] - largest
                if below > -_NEGLIGIBLE:
                    total += np.exp(below)
            out[scan, pose] = (largest - highest) + np.log(total / before)
