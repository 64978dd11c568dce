"""The rule `gaussian`: the weight is a normal density of the distance of the scans (tau 3 of the longer paper)."""

from dataclasses import dataclass
from typing import ClassVar

from voa_core.kernels import Array
from voa_core.rules.distances import DistanceRule


@dataclass(frozen=True)
class Gaussian(DistanceRule):
    """The rule w = exp(-d^2 / (2 sigma_m^2)).

    Attributes:
        sigma_m: standard deviation of d, metres.
    """

    name: ClassVar[str] = "gaussian"
    meaning: ClassVar[str] = "weight exp(-d²/2s²), d the length of the vector of differences, s 1 m unless stated"

    sigma_m: float = 1.0

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        """Logarithms of the weights, -d^2 / (2 sigma_m^2), from d^2; in the shape of `statistic`."""
        log_weights: Array = statistic * statistic.dtype.type(-0.5 / self.sigma_m**2)
        return log_weights
