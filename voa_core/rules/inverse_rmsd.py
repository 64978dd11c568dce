"""The rule `inverse_rmsd`: the weight is the inverse of the root mean squared difference (preliminary paper)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copy_kernels import add_inverse_roots
from voa_core.kernels import Array
from voa_core.rules.distances import DistanceRule


@dataclass(frozen=True)
class InverseRmsd(DistanceRule):
    """The rule w = 1 / max(RMSD, floor_m), with RMSD = d / sqrt(compared beams).

    Attributes:
        floor_m: smallest RMSD that counts, metres; it bounds the weight of a perfect match.
    """

    name: ClassVar[str] = "inverse_rmsd"
    meaning: ClassVar[str] = "weight 1 / RMSD, the root of the mean squared difference"

    floor_m: float = 0.001

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Logarithms of the weights, -ln max(RMSD, floor_m), from d^2 over `beams` beams; in its shape."""
        rmsd = np.sqrt(statistic / statistic.dtype.type(beams))
        log_weights: Array = -np.log(np.maximum(rmsd, statistic.dtype.type(self.floor_m)))
        return log_weights

    def log_means(self, statistic: Floats, beams: NDArray[np.intp]) -> Floats:
        """Logarithms (N,) of the mean weight of J copies, from d^2 (J, N) over `beams` (N,) beams."""
        sums = np.zeros(statistic.shape[1])
        add_inverse_roots(statistic, 1.0 / beams, self.floor_m, sums)
        logs: Floats = np.log(sums / len(statistic))
        return logs
