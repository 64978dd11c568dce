"""The interface of an update rule."""

from collections.abc import Mapping
from typing import ClassVar, Protocol

from voa_core.kernels import Array
from voa_core.lidars import LidarModel


class UpdateRule(Protocol):
    """An update rule: it turns the difference of an observed and a predicted scan into the logarithm of a weight.

    A rule works in two steps. `statistic` reduces each pair of scans to one number, which must be a sum over beams:
    callers add up the statistics of disjoint sets of beams. `log_weights` turns such a sum into ln w.

    Ranges are in metres, `inf` is a no-return, and no range is NaN. Arrays are float64 or float32, and results have the
    float type of the arguments. The methods are called from several threads at once and must not change the rule.
    """

    @property
    def no_return_m(self) -> float:
        """Range that stands for a no-return, and upper limit of every return, in distances and RMSD; metres."""

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Sum over c beams for each pair of scans: observed (m, c) and predicted (n, c) give (m, n)."""

    def statistic_among(self, ranges: Array) -> Array:
        """Sum over c beams for each pair of the same scans: (n, c) gives (n, n), `statistic(ranges, ranges)`.

        The result belongs to the caller, who may change it.
        """

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Natural logarithms of the weights, in the shape of `statistic`; -inf is a weight of 0.

        Args:
            statistic: sums over `beams` compared beams, of any shape.
            beams: number of beams that were compared, at least 1.
        """


class BuiltInRule(UpdateRule, Protocol):
    """A rule of `registry.RULES`: beside its weights it knows its name, its meaning and its defaults.

    Attributes:
        name: name of the rule in scenarios.
        meaning: the rule in one sentence, for reports.
    """

    name: ClassVar[str]
    meaning: ClassVar[str]

    @classmethod
    def defaults(cls, lidar: LidarModel, *, spread: bool = False) -> dict[str, float]:
        """Every parameter of the rule with its default for a lidar; `spread` where the scenario states a spread."""

    @classmethod
    def of(cls, lidar: LidarModel, parameters: Mapping[str, float]) -> "BuiltInRule":
        """Make the rule for a lidar from a value for each of its parameters; raises InvalidInput."""
