"""Weights between predicted scans: what a look would do to the belief, for every pose it could find.

W[q, p] is proportional to the weight that pose p gets when the scan predicted for pose q is observed. It does not
depend on the belief, so it is worth keeping per sensor configuration.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.kernels import Array
from voa_core.prediction import Prediction
from voa_core.rules.distances import squared_distance
from voa_core.rules.protocol import UpdateRule

_POSES_AT_ONCE = 2048  # beyond, a matrix is computed in parts of as many numbers: a second at most each


def wanted() -> None:
    """Find that the work is still wanted: the check of whoever has none."""


@dataclass(frozen=True, eq=False)
class Weigher:
    """The weights between the predicted scans of one sensor configuration, as a rule gives them.

    Attributes:
        rule: how differences become weights.
        ranges: (n, c) predicted ranges on the beams on which some pose returns, as they are compared.
        beams: number of beams of a scan; all of them are compared, for predictions have no missing beams.
        dtype: float64 or float32, of the weights.
        matrix: (n, n) all weights where they are kept, else None.
    """

    rule: UpdateRule
    ranges: Floats
    beams: int
    dtype: np.dtype[Any]
    matrix: Array | None = None

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
        """For a prediction; `keep` computes the whole matrix now, large ones in parts with a `check` before each."""
        weigher = cls(rule, prediction.ranges, prediction.grid.beams, np.dtype(dtype))
        if not keep:
            return weigher
        n, ranges = len(weigher.ranges), weigher.ranges.astype(weigher.dtype)
        if n <= _POSES_AT_ONCE:
            check()
            weights = _scaled(rule.log_weights(rule.statistic_among(ranges), weigher.beams))
            return cls(rule, weigher.ranges, weigher.beams, weigher.dtype, weights)
        weights = np.zeros((n, n), dtype=weigher.dtype)
        rows = max(1, _POSES_AT_ONCE**2 // n)
        for start in range(0, n, rows):
            check()
            part = rule.statistic(ranges[start : start + rows], ranges)
            weights[start : start + rows] = _scaled(rule.log_weights(part, weigher.beams))
        return cls(rule, weigher.ranges, weigher.beams, weigher.dtype, weights)

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.ranges.nbytes + (0 if self.matrix is None else self.matrix.nbytes)

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """W[rows, columns], each row scaled by a positive number of its own."""
        n = len(self.ranges)
        if self.matrix is not None:
            if len(rows) == len(columns) == n:
                return self.matrix
            return self.matrix[rows] if len(columns) == n else self.matrix[np.ix_(rows, columns)]
        observed, predicted = (self.ranges[index].astype(self.dtype) for index in (rows, columns))
        return _scaled(self.rule.log_weights(self.rule.statistic(observed, predicted), self.beams))

    def log_row(self, row: int) -> Floats:
        """ln w of every pose, exact in float64, when the scan predicted for pose `row` is observed; (n,)."""
        return self.rule.log_weights(self.rule.statistic(self.ranges[row : row + 1], self.ranges)[0], self.beams)

    def distances(self, row: int) -> Floats:
        """d between the scan predicted for pose `row` and those of every pose; (n,) metres."""
        observed = self.ranges[row : row + 1]
        distances: Floats = np.sqrt(squared_distance(observed, self.ranges, self.rule.no_return_m)[0])
        return distances


def _scaled(log_weights: Array) -> Array:
    """Weights whose largest in each row is 1; a row without any weight stays 0."""
    highest = log_weights.max(axis=1, keepdims=True)
    highest[highest == -np.inf] = 0.0
    if highest.any():  # not among predictions under most rules: the diagonal holds weights of 1
        log_weights -= highest
    np.exp(log_weights, out=log_weights)
    return log_weights
