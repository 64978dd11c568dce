"""The distance d between two scans, and the rules that depend on the scans through d alone.

d is the Euclidean norm, over the compared beams, of the differences of coded ranges: a return counts as
`min(range, no_return_m)` and a no-return as `no_return_m`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, number
from voa_core.copy_kernels import log_sums_of_exp
from voa_core.displaced_scans import DisplacedScans
from voa_core.kernels import Array, mirror, squared_distances, squared_distances_among
from voa_core.lidars import LidarModel
from voa_core.rules.distance_comparison import DifferenceComparison


def coded(ranges: Array, no_return_m: float) -> Array:
    """Replace each range by `min(range, no_return_m)`, so that a no-return (inf) becomes `no_return_m`."""
    capped: Array = np.minimum(ranges, ranges.dtype.type(no_return_m))
    return capped


def squared_distance(observed: Array, predicted: Array, no_return_m: float) -> Array:
    """Squared distance d^2 for each pair of scans, square metres: (m, c) and (n, c) give (m, n)."""
    out = np.zeros((len(observed), len(predicted)), dtype=observed.dtype)
    squared_distances(coded(observed, no_return_m), coded(predicted, no_return_m), out)
    return out


def mirrored(triangle: Array, n: int) -> Array:
    """Make the symmetric matrix (n, n) from its upper triangle, row after row, (n (n + 1) / 2,)."""
    square = np.zeros((n, n), dtype=triangle.dtype)
    mirror(triangle, square)
    return square


@dataclass(frozen=True)
class DistanceRule(ABC):
    """Base of the rules whose weight depends on d alone: their statistic is d^2, and each adds `log_weights`.

    The weight is the largest where two scans are equal. A rule with a statistic of its own, which must be the same for
    two scans in both orders and 0 for equal ones, replaces `statistic` and `statistic_of_pairs`.

    Each field of a subclass is a parameter of its rule, a number above 0; its default is the parameter's.

    Attributes:
        no_return_m: range that stands for a no-return, and upper limit of every return, metres.
    """

    no_return_m: float

    def __post_init__(self) -> None:
        for parameter in fields(self):
            number(parameter.name, getattr(self, parameter.name), above=0.0)

    @classmethod
    def defaults(cls, lidar: LidarModel, *, spread: bool = False) -> dict[str, float]:  # noqa: ARG003
        """Every parameter with its default; that of `no_return_m` is the lidar's `range_max`."""
        own = {field.name: field.default for field in fields(cls) if isinstance(field.default, float)}
        return {"no_return_m": lidar.range_max, **own}

    @classmethod
    def of(cls, _lidar: LidarModel, parameters: Mapping[str, float]) -> Self:
        """Make the rule from a value for each of its parameters; raises InvalidInput where one is not above 0."""
        return cls(**parameters)

    @property
    def is_of_squares(self) -> bool:
        """True if scans are compared by d^2, and not in a way of the subclass's own."""
        own = type(self)
        return own.statistic is DistanceRule.statistic and own.comparison is DistanceRule.comparison

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Squared distance d^2 for each pair of scans: (m, c) and (n, c) give (m, n)."""
        return squared_distance(observed, predicted, self.no_return_m)

    def statistic_of_pairs(self, ranges: Array) -> Array:
        """Squared distance d^2 for each pair of the scans (n, c) once: a triangle (n (n + 1) / 2,), see `mirror`."""
        out = np.zeros(len(ranges) * (len(ranges) + 1) // 2, dtype=ranges.dtype)
        squared_distances_among(coded(ranges, self.no_return_m), out)
        return out

    def statistic_among(self, ranges: Array) -> Array:
        """Statistic for each pair of the scans (n, c) in both orders, which are alike: (n, n)."""
        return mirrored(self.statistic_of_pairs(ranges), len(ranges))

    @abstractmethod
    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Natural logarithms of the weights, from d^2; in the shape of `statistic`."""

    def comparison(self, observed: Floats, copies: DisplacedScans) -> DifferenceComparison:
        """Make the comparison of classified scans (N, r), metres, with displaced copies of poses."""
        return DifferenceComparison(self, observed, copies)

    def log_means(self, statistic: Floats, _beams: NDArray[np.intp]) -> Floats:
        """Logarithms (N,) of the mean weight of J copies, from statistics (J, N) of a rule that ignores `beams`."""
        exponents: Floats = np.asarray(self.log_weights(statistic, 1), dtype=np.float64)
        n = statistic.shape[1]
        means = np.zeros(n)
        log_sums_of_exp(exponents, np.zeros(n), np.zeros(n, dtype=np.int64), means)
        means -= np.log(len(statistic))
        return means
