"""An update rule of another package: absolute differences of ranges, each counted up to a cap."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from voa_core.lidars import LidarModel

Array = NDArray[Any]


@dataclass(frozen=True)
class CappedRule:
    """The rule w = exp(-sum over beams of min(|observed - predicted|, cap_m) / scale_m).

    Attributes:
        no_return_m: range that stands for a no-return, and upper limit of every return, metres.
        scale_m: sum of differences that lowers a weight by the factor e, metres.
        cap_m: largest difference that one beam contributes, metres.
    """

    no_return_m: float
    scale_m: float
    cap_m: float

    @classmethod
    def of(cls, parameters: Mapping[str, Any], no_return_m: float, lidar: LidarModel, /) -> Self:
        """Make the rule from the parameters of a scenario; the default of `scale_m` is ten times the lidar's noise."""
        values = {"scale_m": 10.0 * lidar.noise_m, "cap_m": 0.1}
        for name, value in parameters.items():
            if name not in values:
                raise ValueError(f"no parameter {name!r}; the rule has {', '.join(values)}")
            if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0.0:
                raise ValueError(f"{name}: expected a number above 0, got {value!r}")
            values[name] = float(value)
        return cls(no_return_m, **values)

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Sum of capped differences for each pair of scans, metres: (m, c) and (n, c) give (m, n)."""
        seen = np.minimum(observed, self.no_return_m)
        expected = np.minimum(predicted, self.no_return_m)
        sums = [np.minimum(np.abs(scan - expected), self.cap_m).sum(axis=1) for scan in seen]  # (n,) for each scan
        return np.stack(sums)

    def statistic_among(self, ranges: Array) -> Array:
        """Sum of capped differences for each pair of the scans (n, c), metres: (n, n)."""
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        """Natural logarithms of the weights, in the shape of `statistic`."""
        return -statistic / self.scale_m
