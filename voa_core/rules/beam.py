"""The rule `beam`: each beam is a hit, something in front of the object, nothing, or random; for live robots."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from voa_core.checks import Floats, number
from voa_core.displaced_scans import DisplacedScans
from voa_core.errors import InvalidInput
from voa_core.kernels import Array
from voa_core.lidars import LidarModel
from voa_core.mixture import Mixture
from voa_core.mixture_pairs import log_likelihoods
from voa_core.rules.mixture_comparison import MixtureComparison

_Z_SHORT = 0.05
_Z_RANDOM = 0.05
_LAMBDA_SHORT_PER_M = 1.0
_SILHOUETTE_SHARE = 0.05
_ONE_WITNESS_RAD = math.radians(4.0)
_ONE_WITNESS_OF_COPIES_RAD = math.radians(2.0)
_LOG_RANGE = 600.0  # products of densities stay within e^-600 and e^600
_LEAST_SHARE = 1e-9  # of random returns per metre, and of no-returns


@dataclass(frozen=True)
class Beam:
    r"""The rule `beam`: the beam model of Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), 6.3, tempered.

    For one beam with measured range z and predicted range z*, over [0, z_max] (z_max: the lidar's `range_max`;
    N the normal density with standard deviation sigma(z*), its tails beyond [0, z_max] neglected):

    | measured  | predicted | p                                                                               |
    |-----------|-----------|---------------------------------------------------------------------------------|
    | return    | return    | z_hit N(z; z*, sigma) + [z <= z*] z_short l e^{-l z} / (1 - e^{-l z*}) + z_random/z_max |
    | no-return | return    | z_no_return                                                                     |
    | return    | no-return | z_hit / (2 z_max) + z_short l e^{-l z} / (1 - e^{-l z_max}) + z_random / z_max  |
    | no-return | no-return | z_hit / 2 + z_no_return                                                         |

    sigma(z*) = max(sigma_hit_m, noise_ratio z*). Returns are densities per metre, no-returns probabilities. The
    predictions know the object alone: where none is predicted, whatever stands behind the object is as likely to
    return as nothing is, hence the halves. w = (product over beams)^temper: neighbouring beams err together
    (a pose that is off by millimetres, a beam that grazes), so they are not that many witnesses.

    Attributes:
        z_hit, z_short, z_no_return, z_random: shares of the mixture; scaled to sum to 1.
        sigma_hit_m: standard deviation of a hit close by, metres.
        lambda_short_per_m: l, decay of unexpected returns with range, 1/m.
        temper: exponent, in (0, 1].
        range_max, noise_ratio: the lidar's.
    """

    name: ClassVar[str] = "beam"
    meaning: ClassVar[str] = "this project's rule for live robots: every beam is a hit, too short, empty or random"

    no_return_m: float
    z_hit: float
    z_short: float
    z_no_return: float
    z_random: float
    sigma_hit_m: float
    lambda_short_per_m: float
    temper: float
    range_max: float
    noise_ratio: float

    def __post_init__(self) -> None:
        for name in ("no_return_m", "sigma_hit_m", "lambda_short_per_m", "range_max"):
            number(name, getattr(self, name), above=0.0)
        for name in ("z_hit", "z_short", "z_no_return", "z_random", "noise_ratio"):
            number(name, getattr(self, name), at_least=0.0)
        if not 0.0 < self.temper <= 1.0:
            raise InvalidInput("temper", "a number above 0 and at most 1", repr(self.temper))
        if self._total() <= 0.0:
            raise InvalidInput("z_hit, z_short, z_no_return, z_random", "a sum above 0", "0")

    @classmethod
    def defaults(cls, lidar: LidarModel, *, spread: bool = False) -> dict[str, float]:
        """Every parameter with its default for a lidar, and why (deploy/decisions/0004-beam-rule.md).

        * `no_return_m` is the lidar's `range_max`, and `sigma_hit_m` its `noise_m`.
        * `z_no_return` is the lidar's `dropout` and 0.05 for beams that slip past an edge; `z_short` and `z_random`
          are 0.05 each (an edge that returns a mixture of near and far, a cable, a hand); `z_hit` is the rest.
        * `lambda_short_per_m` is 1: an obstacle in front of the object stands anywhere within a metre.
        * `temper` makes one witness of every 4 degrees: errors of pose and shape are common to neighbouring beams, so
          a lidar with finer beams is not more certain. With a spread it makes one of every 2 degrees: the weight is a
          mean over displaced copies of each pose, which accounts for the errors of pose.
        """
        one_witness = _ONE_WITNESS_OF_COPIES_RAD if spread else _ONE_WITNESS_RAD
        lost = _SILHOUETTE_SHARE + lidar.dropout
        return {
            "no_return_m": lidar.range_max,
            "z_hit": max(0.0, 1.0 - _Z_SHORT - _Z_RANDOM - lost),
            "z_short": _Z_SHORT,
            "z_no_return": lost,
            "z_random": _Z_RANDOM,
            "sigma_hit_m": lidar.noise_m,
            "lambda_short_per_m": _LAMBDA_SHORT_PER_M,
            "temper": min(1.0, abs(lidar.grid.angle_increment) / one_witness),
        }

    @classmethod
    def of(cls, lidar: LidarModel, parameters: Mapping[str, float]) -> Self:
        """Make the rule for a lidar from a value for each of its parameters; raises InvalidInput."""
        return cls(**parameters, range_max=lidar.range_max, noise_ratio=lidar.noise_ratio)

    def _total(self) -> float:
        return self.z_hit + self.z_short + self.z_no_return + self.z_random

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Log-likelihood of each observed scan under each predicted one: (m, c) and (n, c) give (m, n)."""
        return log_likelihoods(observed, predicted, self._mixture())

    def statistic_among(self, ranges: Array) -> Array:
        """Log-likelihood of each of the scans (n, c) under each other: (n, n)."""
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        """Logarithms of the weights, `temper` times the log-likelihoods; in the shape of `statistic`."""
        log_weights: Array = statistic * statistic.dtype.type(self.temper)
        return log_weights

    def comparison(self, observed: Floats, copies: DisplacedScans) -> MixtureComparison | None:
        """Make the comparison of classified scans (N, r), metres, with displaced copies of poses.

        None where random returns hardly occur, or where no copy can explain a beam: products of such densities do not
        fit the loops that are made for many copies.
        """
        mixture = self._mixture()
        lowest = min(mixture.random, mixture.lost)
        if lowest < _LEAST_SHARE:
            return None
        nearest = min(max(copies.nearest, 1e-9), self.range_max)
        short = mixture.short / -math.expm1(-nearest * mixture.decay_per_m)
        hit, behind = mixture.hit_peak / mixture.sigma_m, (mixture.nothing - mixture.lost) / self.range_max
        highest = max(mixture.random + short + max(hit, behind), 1.0)
        factors = max(1, int(_LOG_RANGE / math.log(highest / lowest)))
        return MixtureComparison(mixture._replace(factors=factors), observed, copies)

    def _mixture(self) -> Mixture:
        """Make the numbers of the mixture, with products of a single factor."""
        hit, short, lost, random = (
            share / self._total() for share in (self.z_hit, self.z_short, self.z_no_return, self.z_random)
        )
        return Mixture(
            hit / math.sqrt(2.0 * math.pi),
            short * self.lambda_short_per_m,
            random / self.range_max,
            lost,
            0.5 * hit + lost,
            self.lambda_short_per_m,
            self.sigma_hit_m,
            self.noise_ratio,
            self.range_max,
            float(self.temper),
            factors=1,
        )
