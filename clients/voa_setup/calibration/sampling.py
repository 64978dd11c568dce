"""Posterior distribution of the lidar's pose around a proposal, by adaptive importance sampling.

The samples of each step are drawn from a normal distribution that is fitted to the weighted samples of the step before,
while the standard deviation of the ranges shrinks from coarse to its true value (annealing). Unlike the curvature at
the best fit, the spread of the samples also accounts for beams at the object's edges, which either meet it or do not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from voa_setup.calibration.planar import Floats

LogDensity = Callable[[Floats, float], Floats]
"""Log density (k,) of polar coordinates (k, 3), for a standard deviation of the ranges in metres."""

START_STD = np.array([0.12, 0.02, 0.05])
"""Standard deviations of bearing (rad), distance (m) and turn (rad) around a proposal."""
_INFLATION = 1.3
_LEAST_STD = np.array([1e-4, 1e-5, 1e-5])


@dataclass(frozen=True, eq=False)
class Cloud:
    """Weighted samples of a distribution.

    Attributes:
        samples: (k, 3) polar coordinates.
        weights: (k,) sum 1.
        best: (3,) sample with the largest density.
        best_log: its log density.
    """

    samples: Floats
    weights: Floats
    best: Floats
    best_log: float

    @property
    def mean(self) -> Floats:
        """Mean, (3,)."""
        return np.asarray(self.weights @ self.samples, dtype=np.float64)

    @property
    def covariance(self) -> Floats:
        """Covariance, (3, 3)."""
        off = self.samples - self.mean
        return np.asarray((off * self.weights[:, None]).T @ off, dtype=np.float64)

    @property
    def effective(self) -> float:
        """Effective number of samples, 1 / sum of squared weights."""
        return float(1.0 / (self.weights**2).sum())


def sampled(
    density: LogDensity,
    mean: Floats,
    covariance: Floats,
    sigmas_m: Sequence[float],
    count: int,
    random: np.random.Generator,
) -> Cloud:
    """Sample a density, first with a coarse standard deviation of the ranges and last with its true one.

    Args:
        density: log density, up to a constant.
        mean, covariance: (3,) and (3, 3) of the first samples.
        sigmas_m: standard deviations of the ranges, one for each step, metres.
        count: number of samples of each step.
        random: generator of the samples.
    """
    cloud = None
    for sigma_m in sigmas_m:
        if cloud is not None:
            mean = 0.5 * (cloud.mean + cloud.best) if cloud.effective < 0.02 * count else cloud.mean
            covariance = cloud.covariance * _INFLATION**2 + _kernel(cloud, covariance)
        cloud = _step(density, mean, covariance, sigma_m, count, random)
    if cloud is None:
        raise ValueError("expected at least one standard deviation of the ranges")
    return cloud


def _kernel(cloud: Cloud, before: Floats) -> Floats:
    """Widen a distribution that rests on few samples, so that the next step does not collapse onto them."""
    share = min(1.0, 4.0 / cloud.effective)
    return np.asarray(0.1 * share * before + np.diag(_LEAST_STD**2), dtype=np.float64)


def _step(
    density: LogDensity, mean: Floats, covariance: Floats, sigma_m: float, count: int, random: np.random.Generator
) -> Cloud:
    root = np.linalg.cholesky(covariance)
    normal = random.standard_normal((count, 3))
    samples = mean + normal @ root.T
    samples[0], normal[0] = mean, 0.0
    logs = density(samples, sigma_m)
    weights = logs + 0.5 * (normal**2).sum(axis=1)
    weights = np.exp(weights - weights.max())
    best = int(np.argmax(logs))
    return Cloud(samples, weights / weights.sum(), samples[best].copy(), float(logs[best]))
