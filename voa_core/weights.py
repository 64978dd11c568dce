"""Weights between predicted scans: the effect that a look would have on the belief, for each true pose.

W[q, p] is proportional to the weight that pose p gets when the scan predicted for pose q is observed. It does not
depend on the belief, so callers keep it for each sensor configuration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import belief_after
from voa_core.filtering import Belief
from voa_core.kernels import Array
from voa_core.prediction import Prediction
from voa_core.rules.distances import DistanceRule, mirrored, squared_distance
from voa_core.rules.protocol import UpdateRule
from voa_core.screening import rough_weights
from voa_core.updating import UpdatePolicy
from voa_core.vector_math import take_exponentials

_POSES_AT_ONCE = 2048  # a larger matrix is computed in parts of as many numbers, at most a second each
_PAIRS_AT_ONCE = 2**14  # statistics and log weights of as many, 256 KiB in float64, stay in a second-level cache


def wanted() -> None:
    """Check that never ends a computation, for callers that have none of their own."""


@dataclass(frozen=True, eq=False)
class Weigher:
    """Weights between the predicted scans of one sensor configuration under an update rule.

    Attributes:
        rule: the update rule.
        ranges: (n, c) predicted ranges, metres, on the beams on which some pose returns.
        beams: number of beams of a scan; all of them are compared, for predictions have no missing beams.
        dtype: float64 or float32, of the weights.
        rounded: True to keep weights of float64 in float32 too, once a ranking has screened grasps by them.
        matrix: (n, n) all weights where they are kept, else None. In float32 they lie column by column in memory: a
            ranking multiplies their transpose, which OpenBLAS does a third faster then; in float64 it does not.
    """

    rule: UpdateRule
    ranges: Floats
    beams: int
    dtype: np.dtype[Any]
    rounded: bool = True
    matrix: Array | None = None

    @classmethod
    def of(
        cls,
        rule: UpdateRule,
        prediction: Prediction,
        dtype: type[np.floating],
        *,
        keep: bool,
        rounded: bool = True,
        check: Callable[[], None] = wanted,
    ) -> "Weigher":
        """Make the weights of a prediction.

        Args:
            rule: the update rule.
            prediction: of all poses at one sensor configuration, limited as it is compared (`evidence.restricted`).
            dtype: float64 or float32, of the weights.
            keep: True to compute the whole matrix now, and to keep it.
            rounded: True if a matrix of float64 may be kept in float32 too, which takes half as much memory again.
            check: called before each part of the matrix; an error that it raises ends the computation.
        """
        weigher = cls(rule, prediction.ranges, prediction.grid.beams, np.dtype(dtype), rounded)
        if not keep:
            return weigher
        n, ranges = len(weigher.ranges), weigher.ranges.astype(weigher.dtype)
        order: Literal["F", "C"] = "F" if weigher.dtype == np.float32 else "C"
        if n <= _POSES_AT_ONCE:
            check()
            return replace(weigher, matrix=np.asarray(_weights_among(rule, ranges, weigher.beams), order=order))
        weights = np.zeros((n, n), dtype=weigher.dtype, order=order)
        rows = max(1, _POSES_AT_ONCE**2 // n)
        for start in range(0, n, rows):
            check()
            part = rule.statistic(ranges[start : start + rows], ranges)
            weights[start : start + rows] = scale_rows(rule.log_weights(part, weigher.beams))
        return replace(weigher, matrix=weights)

    @cached_property
    def rough(self) -> Array | None:
        """The kept weights in float32, made when first needed; None where they are not kept so."""
        return rough_weights(self.matrix) if self._is_rounded and self.matrix is not None else None

    @property
    def _is_rounded(self) -> bool:
        return self.rounded and self.dtype == np.float64

    @property
    def samples(self) -> int:
        """Number of scans of each pose: the predicted one."""
        return 1

    @property
    def simulated(self) -> bool:
        """False: the scans are predictions, without noise."""
        return False

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes, with that of the rounded weights, which may come later."""
        of_matrix = 0 if self.matrix is None else self.matrix.nbytes
        return self.ranges.nbytes + of_matrix + (of_matrix // 2 if self._is_rounded else 0)

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Weights W[rows, columns], each row scaled by a positive number of its own."""
        n = len(self.ranges)
        if self.matrix is not None:
            if len(rows) == len(columns) == n:
                return self.matrix
            return self.matrix[rows] if len(columns) == n else self.matrix[np.ix_(rows, columns)]
        observed, predicted = (self.ranges[index].astype(self.dtype) for index in (rows, columns))
        return scale_rows(self.rule.log_weights(self.rule.statistic(observed, predicted), self.beams))

    def log_row(self, row: int) -> Floats:
        """Logarithm ln w of every pose when the scan predicted for pose `row` is observed, in float64, (n,)."""
        return self.rule.log_weights(self.rule.statistic(self.ranges[row : row + 1], self.ranges)[0], self.beams)

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after the scan predicted for each of the poses `rows`, in logarithms.

        Needed where the weights nearly vanish at every pose that the belief holds possible.
        """
        return [
            belief_after(belief, self.log_row(int(row)), policy, partial(self.distances, int(row)))
            for row, belief in zip(rows, before, strict=True)
        ]

    def most_left_out(self, _rows: NDArray[np.intp], _columns: NDArray[np.intp], _masses: Floats) -> None:
        """None: nothing is left out of the weights."""

    def seen_with(self, _belief: Belief, _policy: UpdatePolicy) -> "Weigher":
        """Weights of this look: a predicted scan shows the object, as far as the rule can say."""
        return self

    def distances(self, row: int) -> Floats:
        """Distance d between the scan predicted for pose `row` and that of every pose, (n,) metres."""
        observed = self.ranges[row : row + 1]
        distances: Floats = np.sqrt(squared_distance(observed, self.ranges, self.rule.no_return_m)[0])
        return distances


def _weights_among(rule: UpdateRule, ranges: Array, beams: int) -> Array:
    """Weights (n, n) between the scans (n, c), each row scaled.

    As many pairs are weighed at a time as fit into a cache of the processor, and in the place of their statistics: more
    large arrays take longer to come from the system than to fill.
    """
    if isinstance(rule, DistanceRule):
        return _weights_of_pairs(rule, ranges, beams)
    weights = rule.statistic_among(ranges)
    rows = max(1, _PAIRS_AT_ONCE // len(weights))
    for first in range(0, len(weights), rows):
        some = weights[first : first + rows]
        some[:] = scale_rows(rule.log_weights(some, beams))
    return weights


def _weights_of_pairs(rule: DistanceRule, ranges: Array, beams: int) -> Array:
    """Weights (n, n) between the scans (n, c), all scaled alike, of a rule of distances.

    It weighs two scans alike in both orders, and each scan itself the most: each pair is weighed once.
    """
    pairs = rule.statistic_of_pairs(ranges)
    highest = rule.log_weights(np.zeros(1, dtype=pairs.dtype), beams)
    for first in range(0, len(pairs), _PAIRS_AT_ONCE):
        some = pairs[first : first + _PAIRS_AT_ONCE]
        log_weights = rule.log_weights(some, beams)
        if highest[0] != 0.0:
            log_weights -= highest
        some[:] = _exponentials(log_weights)
    weights = mirrored(pairs, len(ranges))
    return weights.T if weights.dtype == np.float32 else weights  # columns in a row, as they are kept


def scale_rows(log_weights: Array) -> Array:
    """Turn log weights into weights in place, the largest in each row 1; a row of weights of 0 remains 0."""
    highest = log_weights.max(axis=1, keepdims=True)
    highest[highest == -np.inf] = 0.0
    if highest.any():  # not among predictions under most rules: the diagonal holds weights of 1
        log_weights -= highest
    return _exponentials(log_weights)


def _exponentials(log_weights: Array) -> Array:
    """Turn log weights of at most 0, of any shape, into weights, in place."""
    if log_weights.dtype == np.float64 and log_weights.flags.c_contiguous:
        take_exponentials(log_weights.reshape(-1))
    else:
        np.exp(log_weights, out=log_weights)
    return log_weights
