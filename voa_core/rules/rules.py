r"""Update rules: how a scan turns into a weight per pose.

A rule reduces each pair of an observed and a predicted scan to one *statistic*, a sum over beams, and turns it
into the logarithm of a weight. `d` is the Euclidean norm over the compared beams of the differences of coded
ranges, a range coded as `min(range, no_return_m)` and a no-return as `no_return_m`.

| rule           | w(o, o~)                                    | source                               |
|----------------|---------------------------------------------|--------------------------------------|
| `margin`       | 1 if every beam agrees within `margin_m`    | longer paper, tau 1                  |
| `exponential`  | exp(-d)                                     | longer paper, tau 2                  |
| `gaussian`     | exp(-d^2 / (2 sigma_m^2))                   | longer paper, tau 3                  |
| `inverse_rmsd` | 1 / max(d / sqrt(beams), floor_m)           | preliminary paper                    |
| `beam`         | (product over beams of a mixture)^temper    | Probabilistic Robotics, section 6.3  |

To add a rule: a class here, its entry in `RULES`, and its message in `voa_msgs.updates`.
"""

import math
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import number
from voa_core.errors import InvalidInput, UnknownName
from voa_core.kernels import (
    Array,
    disagreements,
    mixture_likelihoods,
    squared_distances,
    squared_distances_among,
)
from voa_core.lidars import LidarModel


class UpdateRule(Protocol):
    """What every rule offers. Ranges are metres, `inf` a no-return; never NaN."""

    @property
    def no_return_m(self) -> float:
        """What a no-return counts as, and the most that a return counts as, in `d` and RMSD."""

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Sum over beams for each pair: (m, c) and (n, c) give (m, n), in their float type."""

    def statistic_among(self, ranges: Array) -> Array:
        """`statistic(ranges, ranges)`, (n, c) gives (n, n)."""

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Logarithms of the weights, from statistics summed over `beams` compared beams; same shape."""


def coded(ranges: Array, no_return_m: float) -> Array:
    """Ranges as the arithmetic sees them: `min(range, no_return_m)`, a no-return as `no_return_m`."""
    capped: Array = np.minimum(ranges, ranges.dtype.type(no_return_m))
    return capped


def squared_distance(observed: Array, predicted: Array, no_return_m: float) -> Array:
    """d^2 for each pair: (m, c) and (n, c) give (m, n)."""
    out = np.zeros((len(observed), len(predicted)), dtype=observed.dtype)
    squared_distances(coded(observed, no_return_m), coded(predicted, no_return_m), out)
    return out


def _zero_to_minus_infinity(agree: NDArray[np.bool_], dtype: np.dtype[Any]) -> Array:
    return np.where(agree, 0.0, -np.inf).astype(dtype)


@dataclass(frozen=True)
class _ByDistance:
    """Rules that see a scan only through d: their statistic is d^2."""

    no_return_m: float

    def __post_init__(self) -> None:
        for parameter in fields(self):
            number(parameter.name, getattr(self, parameter.name), above=0.0)

    def statistic(self, observed: Array, predicted: Array) -> Array:
        return squared_distance(observed, predicted, self.no_return_m)

    def statistic_among(self, ranges: Array) -> Array:
        out = np.zeros((len(ranges), len(ranges)), dtype=ranges.dtype)
        squared_distances_among(coded(ranges, self.no_return_m), out)
        return out


@dataclass(frozen=True)
class Margin(_ByDistance):
    """w = 1 if every beam agrees within `margin_m` (and a nanometre), else 0; the statistic counts the others."""

    margin_m: float = 0.008

    def statistic(self, observed: Array, predicted: Array) -> Array:
        out = np.zeros((len(observed), len(predicted)), dtype=observed.dtype)
        disagreements(coded(observed, self.no_return_m), coded(predicted, self.no_return_m), self.margin_m, out)
        return out

    def statistic_among(self, ranges: Array) -> Array:
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        return _zero_to_minus_infinity(statistic == 0.0, statistic.dtype)


@dataclass(frozen=True)
class Exponential(_ByDistance):
    """w = exp(-d)."""

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        log_weights: Array = np.sqrt(statistic)
        return np.negative(log_weights, out=log_weights)


@dataclass(frozen=True)
class Gaussian(_ByDistance):
    """w = exp(-d^2 / (2 sigma_m^2))."""

    sigma_m: float = 1.0

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        log_weights: Array = statistic * statistic.dtype.type(-0.5 / self.sigma_m**2)
        return log_weights


@dataclass(frozen=True)
class InverseRmsd(_ByDistance):
    """w = 1 / max(RMSD, floor_m), RMSD = d / sqrt(beams compared)."""

    floor_m: float = 0.001

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        rmsd = np.sqrt(statistic / statistic.dtype.type(beams))
        log_weights: Array = -np.log(np.maximum(rmsd, statistic.dtype.type(self.floor_m)))
        return log_weights


_BLOCK_POSES = 512  # what the beam rule knows of so many predicted scans stays in a core's cache


def _factors_in_range(random_density: float, lost: float, highest: float) -> int:
    """How many factors between the lowest and the highest a product of float64 can surely hold, at least 1."""
    if random_density == 0.0:
        return 1  # nothing bounds the tails of the normal density
    lowest = min(random_density, lost) if lost > 0.0 else random_density
    return max(1, int(600.0 / max(abs(math.log(lowest)), abs(math.log(highest)), 1.0)))


@dataclass(frozen=True)
class Beam:
    r"""The beam model of Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 6.3, in logs and tempered.

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

    def _total(self) -> float:
        return self.z_hit + self.z_short + self.z_no_return + self.z_random

    def statistic(self, observed: Array, predicted: Array) -> Array:
        parts = [predicted[start : start + _BLOCK_POSES] for start in range(0, len(predicted), _BLOCK_POSES)]
        return np.concatenate([self._log_likelihoods(observed, part) for part in parts], axis=1)

    def _log_likelihoods(self, observed: Array, predicted: Array) -> Array:
        """Logarithms of the products over beams: (m, c) and (n, c) give (m, n)."""
        hit, short, lost, random = (
            share / self._total() for share in (self.z_hit, self.z_short, self.z_no_return, self.z_random)
        )
        decay = self.lambda_short_per_m
        returned = np.isfinite(predicted.T)
        poses = np.nonzero(returned)[1]
        expected = predicted.T[returned].astype(np.float64)
        within = np.clip(expected, 1e-9, self.range_max)
        sigma = np.maximum(self.sigma_hit_m, self.noise_ratio * within)
        hit_peak = hit / (math.sqrt(2.0 * math.pi) * sigma)
        short_peak = short * decay / -np.expm1(-decay * within)
        highest = random / self.range_max + hit_peak.max(initial=0.0) + short_peak.max(initial=0.0)
        short_decay = np.exp(-decay * observed.astype(np.float64))
        background = (0.5 * hit + random) / self.range_max
        if_none = background + short * decay * short_decay / -math.expm1(-decay * self.range_max)
        products, logs = (np.zeros((len(observed), len(predicted))) for _ in range(2))
        with np.errstate(divide="ignore"):
            mixture_likelihoods(
                observed,
                short_decay,
                if_none,
                np.where(returned, lost, 0.5 * hit + lost),
                np.concatenate([[0], np.cumsum(returned.sum(axis=1))]),
                poses,
                expected,
                1.0 / sigma,
                hit_peak,
                short_peak,
                random / self.range_max,
                _factors_in_range(random / self.range_max, lost, highest),
                products,
                logs,
            )
            np.log(products, out=products)
        products += logs
        return products.astype(observed.dtype, copy=False)

    def statistic_among(self, ranges: Array) -> Array:
        return self.statistic(ranges, ranges)

    def log_weights(self, statistic: Array, _beams: int, /) -> Array:
        log_weights: Array = statistic * statistic.dtype.type(self.temper)
        return log_weights


RULES: dict[str, type[Margin | Exponential | Gaussian | InverseRmsd | Beam]] = {
    "margin": Margin,
    "exponential": Exponential,
    "gaussian": Gaussian,
    "inverse_rmsd": InverseRmsd,
    "beam": Beam,
}

_Z_SHORT = 0.05
_Z_RANDOM = 0.05
_LAMBDA_SHORT_PER_M = 1.0
_SILHOUETTE_SHARE = 0.05
_ONE_WITNESS_RAD = math.radians(4.0)


def defaults(name: str, lidar: LidarModel) -> dict[str, float]:
    """Every parameter of the rule `name` with its default for this lidar.

    Those of `beam`, and why (deploy/decisions/0004-beam-rule.md):

    * `sigma_hit_m` is the lidar's `noise_m`.
    * `z_no_return` is the lidar's `dropout` and 0.05 for beams that slip past an edge; `z_short` and `z_random`
      are 0.05 each (an edge that returns a mixture of near and far, a cable, a hand); `z_hit` is the rest.
    * `lambda_short_per_m` is 1: what stands in between stands anywhere within a metre.
    * `temper` makes one witness of every 4 degrees: errors of pose and shape are common to neighbouring beams, so
      a lidar with finer beams is not the surer for it.

    Raises:
        UnknownName: there is no such rule.
    """
    if name not in RULES:
        raise UnknownName("update rule", name, list(RULES))
    found: dict[str, float] = {"no_return_m": lidar.range_max}
    for field in fields(RULES[name]):
        if isinstance(field.default, float):
            found[field.name] = field.default
    if name == "beam":
        lost = _SILHOUETTE_SHARE + lidar.dropout
        found |= {
            "z_hit": max(0.0, 1.0 - _Z_SHORT - _Z_RANDOM - lost),
            "z_short": _Z_SHORT,
            "z_no_return": lost,
            "z_random": _Z_RANDOM,
            "sigma_hit_m": lidar.noise_m,
            "lambda_short_per_m": _LAMBDA_SHORT_PER_M,
            "temper": min(1.0, abs(lidar.grid.angle_increment) / _ONE_WITNESS_RAD),
        }
    return found


def rule_of(name: str, lidar: LidarModel, **parameters: float) -> UpdateRule:
    """The rule `name` with `parameters`, and its defaults for this lidar where none is given.

    Raises:
        UnknownName: there is no such rule, or the rule has no such parameter.
        InvalidInput: a parameter is out of its limits.
    """
    values = defaults(name, lidar)
    for parameter in parameters:
        if parameter not in values:
            raise UnknownName(f"parameter of the update rule {name!r}", parameter, list(values))
    values |= parameters
    if name == "beam":
        values |= {"range_max": lidar.range_max, "noise_ratio": lidar.noise_ratio}
    return RULES[name](**values)
