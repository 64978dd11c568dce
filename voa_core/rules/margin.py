"""The rule `margin`: a pose stays possible while every beam agrees (tau 1 of the longer paper)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from voa_core.checks import Floats
from voa_core.displaced_scans import DisplacedScans
from voa_core.kernels import Array, disagreements
from voa_core.rules.distance_comparison import DifferenceComparison
from voa_core.rules.distances import DistanceRule, coded


@dataclass(frozen=True)
class Margin(DistanceRule):
    """The rule w = 1 if every beam agrees within `margin_m` (and a nanometre), else 0.

    Its statistic is the number of beams that disagree.

    Attributes:
        margin_m: largest difference of two ranges that agree, metres.
    """

    name: ClassVar[str] = "margin"
    meaning: ClassVar[str] = (
        "a pose stays possible if every beam agrees within a margin (8 mm unless stated); all others are excluded"
    )

    margin_m: float = 0.008

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Number of beams that disagree for each pair of scans: (m, c) and (n, c) give (m, n)."""
        out = np.zeros((len(observed), len(predicted)), dtype=observed.dtype)
        disagreements(coded(observed, self.no_return_m), coded(predicted, self.no_return_m), self.margin_m, out)
        return out

    def statistic_of_pairs(self, ranges: Array) -> Array:
        """Number of beams that disagree for each pair of the scans (n, c) once: a triangle, (n (n + 1) / 2,)."""
        scans, n = coded(ranges, self.no_return_m), len(ranges)
        out, begin = np.zeros(n * (n + 1) // 2, dtype=ranges.dtype), 0
        for first in range(n):
            row = out[None, begin : begin + n - first]
            disagreements(scans[first : first + 1], scans[first:], self.margin_m, row)
            begin += n - first
        return out

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        """Logarithms of the weights: 0 where no beam disagrees, else -inf; in the shape of `statistic`."""
        return np.where(statistic == 0.0, 0.0, -np.inf).astype(statistic.dtype)

    def comparison(self, observed: Floats, copies: DisplacedScans) -> DifferenceComparison:
        """Make the comparison of classified scans (N, r), metres, with displaced copies of poses."""
        return DifferenceComparison(self, observed, copies, self.margin_m)
