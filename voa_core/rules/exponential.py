"""The rule `exponential`: the weight falls with the distance of the scans (tau 2 of the longer paper)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from voa_core.kernels import Array
from voa_core.rules.distances import DistanceRule


@dataclass(frozen=True)
class Exponential(DistanceRule):
    """The rule w = exp(-d), d in metres."""

    name: ClassVar[str] = "exponential"
    meaning: ClassVar[str] = "weight exp(-d), d the length of the vector of differences in metres"

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        """Logarithms of the weights, -d, from d^2; in the shape of `statistic`."""
        log_weights: Array = np.sqrt(statistic)
        return np.negative(log_weights, out=log_weights)
