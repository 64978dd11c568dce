"""Weights after simulated scans: the effect that a look would have on the belief, for each sample of each pose.

W[i, p] is the weight that pose p gets when the simulated scan i is observed. It does not depend on the belief, so
callers keep it for each place, as `weights.Weigher` between exact scans; only a place that was looked from in a session
has weights of its own in that session. Where a place has too many weights to keep, they are computed for some scans
at a time, each time that they are needed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import belief_after
from voa_core.copies import Copies, SimulatedScans, distances, log_mean_weights, log_mean_weights_of_each, negligible
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief, condition
from voa_core.kernels import Array
from voa_core.lidars import SensorConfiguration
from voa_core.sample_sight import SampleSight, sight_of_samples
from voa_core.scan_model import ScanModel
from voa_core.sight import BEHIND_M
from voa_core.simulation import Sampling
from voa_core.updating import UpdatePolicy, nearest
from voa_core.weights import scale_rows, wanted

_MOST_KEPT = 2**22
"""Most weights of a place that are kept, or computed at a time: 32 MiB in float64."""


@dataclass(frozen=True, eq=False)
class SimulatedWeights:
    """Weights of every pose after each sample of the scans of one place.

    Attributes:
        model: of the scans.
        copies: predictions of the displaced copies of all poses at this place.
        scans: one or more scans in a row of each sample, of N samples in all.
        samples: number K of samples of each pose.
        log_sums: (n, J) log weights of earlier looks from the place, summed; None: there are none.
        refused: (N,) for each scan in a row, flags of the samples in which it is not accepted whatever the belief.
        sights: for each scan in a row, the beams that could see the object.
        dtype: type of the weights, float64 or float32.
        matrix: (N, n) each row scaled so that its largest weight is 1; None: the weights are computed when needed.
        left_out: (N,) largest total that weights left out of a row of `matrix` may have, on its scale.
        judged: True if scans that do not show the object count for nothing already.
    """

    model: ScanModel
    copies: Copies = field(repr=False)
    scans: tuple[SimulatedScans, ...]
    samples: int
    log_sums: Floats | None
    refused: tuple[NDArray[np.bool_], ...]
    sights: tuple[SampleSight, ...]
    dtype: np.dtype[Any]
    left_out: Floats
    matrix: Array | None = None
    judged: bool = False

    @classmethod
    def of(
        cls,
        model: ScanModel,
        sensor: SensorConfiguration,
        sampling: Sampling,
        dtype: type[np.floating] = np.float64,
        *,
        listed: bool = False,
        looks: int = 1,
        log_sums: Floats | None = None,
        check: Callable[[], None] = wanted,
    ) -> "SimulatedWeights":
        """Simulate scans at a place and compute the weights of every pose after them.

        Args:
            model: of the scans.
            sensor: the place.
            sampling: how many samples of each pose, and which.
            dtype: float64 or float32, of the weights that are kept.
            listed: True if the scenario lists the sensor.
            looks: number of scans in a row from this place; they share their displacement.
            log_sums: (n, J) log weights of a session's looks from the place, summed; None: there are none.
            check: called between blocks; an error that it raises ends the computation.

        Raises:
            NoMesh: there is no prediction for the sensor.
            InvalidInput: `log_sums` has fewer copies than a look from there needs, or there is no look.
        """
        if looks < 1:
            raise InvalidInput("looks", "at least 1", str(looks))
        displacements = model.displacements(sensor, 1 if log_sums is None else log_sums.shape[1])
        if displacements is None or (log_sums is not None and log_sums.shape[1] == 1):
            log_sums = None  # earlier looks weigh all copies of a pose alike
        if log_sums is not None and displacements is not None and log_sums.shape != displacements.shape[:2]:
            n, copies_needed = displacements.shape[:2]
            expected = f"shape {n}x{copies_needed}, one number per pose and displaced copy"
            raise InvalidInput("log_sums", expected, f"shape {'x'.join(map(str, log_sums.shape))}")
        scans = model.scans(
            sensor, sampling, listed=listed, looks=looks, displacements=displacements, log_sums=log_sums
        )
        check()
        copies = model.copies(sensor, displacements, listed=listed, keep=True)
        check()
        sights = tuple(
            sight_of_samples(scan, copies, np.inf if model.workspace is not None else BEHIND_M) for scan in scans
        )
        refused = tuple(_refused(model, scan, copies) for scan in scans)
        number, n = len(scans[0].ranges), len(model.poses)
        left_out = np.full(number, math.exp(-negligible(n)))
        computed = cls(model, copies, scans, sampling.samples, log_sums, refused, sights, np.dtype(dtype), left_out)
        if number * n <= _MOST_KEPT:
            matrix, left_out = computed._scaled(np.arange(number), check)
            computed = replace(computed, matrix=matrix, left_out=left_out)
        return replace(computed, copies=model.copies(sensor, displacements, listed=listed, keep=False))

    @property
    def panels(self) -> None:
        """None: the weights are kept scan by scan."""
        return None

    def all_weights(self, _check: Callable[[], None]) -> None:
        """None: the weights of a look are kept scan by scan, or computed for some scans at a time."""

    @property
    def simulated(self) -> bool:
        """True: the scans are drawn from the sensor model."""
        return True

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        of_sights = sum(sight.reach.nbytes + sight.fewest.nbytes for sight in self.sights)
        of_matrix = 0 if self.matrix is None else self.matrix.nbytes
        return of_matrix + sum(scan.ranges.nbytes for scan in self.scans) + of_sights + self.copies.nbytes

    def seen_with(self, belief: Belief, policy: UpdatePolicy) -> "SimulatedWeights":
        """Weights with which scans that do not show the object change nothing, under a belief that may not expect them.

        A scan is judged with the poses that `belief` holds possible before any of the scans in a row.
        """
        if self.judged or policy.on_nothing_seen != "reject":
            return self
        possible = belief.p > 0.0
        missed = [sight.misses_object(scan, possible) for scan, sight in zip(self.scans, self.sights, strict=True)]
        refused = tuple(old | new for old, new in zip(self.refused, missed, strict=True))
        if not any((new & ~old).any() for old, new in zip(self.refused, refused, strict=True)):
            return replace(self, judged=True)
        judged = replace(self, refused=refused, judged=True)
        if self.matrix is None:
            return judged
        if len(self.scans) == 1:
            matrix = self.matrix.copy()
            matrix[refused[0]] = 1.0
            return replace(judged, matrix=matrix, left_out=np.where(refused[0], 0.0, self.left_out))
        return replace(judged, matrix=judged._scaled(np.arange(len(self.matrix)))[0])

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Weights W[rows, columns], each row scaled by a positive number of its own."""
        if self.matrix is None:
            blocks = np.array_split(rows, math.ceil(len(rows) * len(self.model.poses) / _MOST_KEPT))
            return np.concatenate([self._scaled(block)[0][:, columns] for block in blocks])
        every_scan, every_pose = map(np.arange, self.matrix.shape)
        if not np.array_equal(columns, every_pose):
            return self.matrix[np.ix_(rows, columns)]
        return self.matrix if np.array_equal(rows, every_scan) else self.matrix[rows]

    def most_left_out(self, rows: NDArray[np.intp], _columns: NDArray[np.intp], _masses: Floats) -> Floats:
        """Most, (k,), that is left out of the weight of any pose after the samples `rows`, as they are scaled."""
        return self.left_out[rows]

    def log_rows(self, rows: NDArray[np.intp], check: Callable[[], None] = wanted) -> Floats:
        """Logarithms ln w of every pose after the samples `rows`, in float64, (k, n)."""
        logs = np.zeros((len(rows), len(self.model.poses)))
        scans = [scan.part(rows) for scan in self.scans]
        refused = [flags[rows] for flags in self.refused]
        log_mean_weights(scans, refused, self.copies, self.model.rule, self.log_sums, logs, check)
        return logs

    def _scaled(self, rows: NDArray[np.intp], check: Callable[[], None] = wanted) -> tuple[Array, Floats]:
        """Compute the weights (k, n) after the samples `rows`, each row scaled, and what may be left out of each."""
        if len(self.scans) > 1 or self.log_sums is not None or self.copies.per_pose == 1:
            logs = self.log_rows(rows, check)
            return scale_rows(logs).astype(self.dtype, copy=False), np.zeros(len(rows))
        logs = np.zeros((len(rows), len(self.model.poses)))
        own, refused = rows // self.samples, self.refused[0][rows]
        least = log_mean_weights_of_each(self.scans[0].part(rows), own, self.copies, self.model.rule, logs, check)
        logs[refused] = 0.0
        left_out = np.zeros(len(rows))
        if least is not None:
            left_out = np.where(refused, 0.0, np.exp(np.minimum(least - logs.max(axis=1), 0.0)))
        return scale_rows(logs).astype(self.dtype, copy=False), left_out

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after each of the samples `rows` from that before it, in logarithms."""
        if len(rows) == 0:
            return []
        logs = self.log_rows(rows)
        if len(self.scans) == 1:
            return [
                belief_after(belief, logs[index], policy, partial(self._distances, rows[index], self.scans[0]))
                for index, belief in enumerate(before)
            ]
        after = [condition(belief, log_weights) for belief, log_weights in zip(before, logs, strict=True)]
        return [
            self._one_by_one(rows[index], before[index], policy) if posterior is None else posterior.belief
            for index, posterior in enumerate(after)
        ]

    def _one_by_one(self, row: np.intp, belief: Belief, policy: UpdatePolicy) -> Belief:
        """Belief after the scans of a sample one after the other, where no possible pose explains them all."""
        index, earlier, after = np.array([row]), self.log_sums, belief
        accepted: list[SimulatedScans] = []
        for scan, refused in zip(self.scans, self.refused, strict=True):
            if refused[row]:
                continue
            logs = np.zeros((1, len(self.model.poses)))
            together = [*accepted, scan.part(index)]
            counted = [np.zeros(1, dtype=bool)] * len(together)
            log_mean_weights(together, counted, self.copies, self.model.rule, earlier, logs)
            posterior = condition(belief, logs[0])
            if posterior is not None:
                accepted, after = together, posterior.belief
            elif policy.on_no_match == "nearest":  # it makes the belief, and the place forgets its looks
                belief = after = nearest(self._distances(row, scan))
                accepted, earlier = [], None
        return after

    def _distances(self, row: np.intp, scan: SimulatedScans) -> Floats:
        away: Floats = distances(scan.part(np.array([row])), self.copies, self.model.rule.no_return_m)[0]
        return away


def simulated_looks(
    model: ScanModel,
    sampling: Sampling,
    dtype: type[np.floating] = np.float64,
    *,
    lists: Callable[[SensorConfiguration], bool],
    log_sums_of: Callable[[SensorConfiguration], Floats | None],
    check: Callable[[], None] = wanted,
) -> Callable[[SensorConfiguration, int], SimulatedWeights]:
    """Make a function that gives the weights after simulated scans in a row from a sensor configuration.

    Args:
        model: of the scans.
        sampling: how many samples of each pose, and which.
        dtype: float64 or float32, of the weights.
        lists: True for a sensor configuration that the scenario lists.
        log_sums_of: gives the log sums (n, J) of a session's earlier looks from a place; None where there are none.
        check: called between blocks; an error that it raises ends the computation.
    """

    def of(sensor: SensorConfiguration, scans: int) -> SimulatedWeights:
        return SimulatedWeights.of(
            model,
            sensor,
            sampling,
            dtype,
            listed=lists(sensor),
            looks=scans,
            log_sums=log_sums_of(sensor),
            check=check,
        )

    return of


def _refused(model: ScanModel, scans: SimulatedScans, copies: Copies) -> NDArray[np.bool_]:
    """Flags (N,) of the scans that are not accepted whatever the belief: no beam to compare, or too bad a best fit."""
    refused: NDArray[np.bool_] = scans.compared == 0
    limit = model.policy.reject_above_rmsd_mm
    if limit is None:
        return refused
    too_bad = []
    number = len(scans.ranges)
    for rows in np.array_split(np.arange(number), math.ceil(number * len(model.poses) / _MOST_KEPT)):
        some = scans.part(rows)
        logs = np.zeros((len(rows), len(model.poses)))
        log_mean_weights([some], [refused[rows]], copies, model.rule, None, logs)
        away = distances(some, copies, model.rule.no_return_m)
        best = np.where(logs.max(axis=1) > -np.inf, logs.argmax(axis=1), away.argmin(axis=1))
        fits = 1e3 * away[np.arange(len(away)), best] / np.sqrt(np.maximum(some.compared, 1))
        too_bad.append(fits > limit)
    all_refused: NDArray[np.bool_] = refused | np.concatenate(too_bad)
    return all_refused
