"""Weights between predicted scans: the effect that a look would have on the belief, for each true pose.

W[q, p] is proportional to the weight that pose p gets when the scan predicted for pose q is observed. It does not
depend on the belief, so callers keep it for each sensor configuration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import belief_after
from voa_core.filtering import Belief
from voa_core.kernels import Array
from voa_core.panels import Panels
from voa_core.prediction import Prediction
from voa_core.rules.distances import DistanceRule, squared_distance
from voa_core.rules.protocol import UpdateRule
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
        panels: all weights where they are kept, else None.
    """

    rule: UpdateRule
    ranges: Floats
    beams: int
    dtype: np.dtype[Any]
    panels: Panels | None = None

    @classmethod
    def of(
        cls,
        rule: UpdateRule,
        prediction: Prediction,
        dtype: type[np.floating],
        *,
        keep: bool,
        check: Callable[[], None] = wanted,
    ) -> "Weigher":
        """Make the weights of a prediction.

        Args:
            rule: the update rule.
            prediction: of all poses at one sensor configuration, limited as it is compared (`evidence.restricted`).
            dtype: float64 or float32, of the weights.
            keep: True to compute all weights now, and to keep them.
            check: called before each part of the weights; an error that it raises ends the computation.
        """
        weigher = cls(rule, prediction.ranges, prediction.grid.beams, np.dtype(dtype))
        if not keep:
            return weigher
        panels = weigher.all_weights(check)
        if panels is not None:
            return replace(weigher, panels=panels)
        n, ranges = len(weigher.ranges), weigher.ranges.astype(weigher.dtype)
        panels, rows = Panels.empty(n, n, weigher.dtype), max(1, _POSES_AT_ONCE**2 // n)
        for start in range(0, n, rows):
            check()
            part = rule.statistic(ranges[start : start + rows], ranges)
            panels.write(start, scale_rows(rule.log_weights(part, weigher.beams)))
        return replace(weigher, panels=panels)

    def all_weights(self, check: Callable[[], None]) -> Panels | None:
        """Compute all weights at once, which takes half as long as row by row; None: there are too many."""
        if len(self.ranges) > _POSES_AT_ONCE:
            return None
        check()
        return _panels_among(self.rule, self.ranges.astype(self.dtype), self.beams)

    @property
    def matrix(self) -> None:
        """None: the weights are kept in panels."""
        return None

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
        """Memory held, in bytes."""
        return self.ranges.nbytes + (0 if self.panels is None else self.panels.nbytes)

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Weights W[rows, columns], each row scaled by a positive number of its own."""
        if self.panels is not None:
            return self.panels.read(rows, columns)
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


def _panels_among(rule: UpdateRule, ranges: Array, beams: int) -> Panels:
    """Weights (n, n) between the scans (n, c), each row scaled.

    As many pairs are weighed at a time as fit into a cache of the processor, and in the place of their statistics: more
    large arrays take longer to come from the system than to fill.
    """
    if isinstance(rule, DistanceRule):
        return Panels.of_pairs(_weights_of_pairs(rule, ranges, beams), len(ranges))
    n, statistic = len(ranges), rule.statistic_among(ranges)
    panels, rows = Panels.empty(n, n, ranges.dtype), max(1, _PAIRS_AT_ONCE // n)
    for first in range(0, n, rows):
        panels.write(first, scale_rows(rule.log_weights(statistic[first : first + rows], beams)))
    return panels


def _weights_of_pairs(rule: DistanceRule, ranges: Array, beams: int) -> Array:
    """Weights (n (n + 1) / 2,) between each two of the scans (n, c), all scaled alike, of a rule of distances.

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
    return pairs


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
