"""Search for the poses of the lidar that explain the scans of all stops, under one sign of the yaw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from voa_setup.calibration.likelihood import log_likelihoods, residuals
from voa_setup.calibration.planar import Floats, wrapped
from voa_setup.calibration.proposals import lidar_poses, proposals
from voa_setup.calibration.sampling import START_STD, Cloud, sampled
from voa_setup.calibration.stops import Measured, Stop
from voa_setup.calibration.unknowns import Unknown

_COARSE_M = 0.03
_STEPS_M = (0.03, 0.012, 0.006)
"""Standard deviations of the ranges while a proposal is narrowed down, metres."""
_STARTS = 16
_APART = np.array([0.25, 0.05, 0.25])
"""Differences of bearing (rad), distance (m) and turn (rad) up to which two proposals are one."""
_FEW, _MANY = 300, 3000
_LEAST_SIGMA_M = 0.001
_OFFSET_M = 0.002
"""Standard deviation of an offset that all ranges of a stop share, metres: of the lidar, or of the mesh."""
_PRIOR_BEAMS = 4.0
_FEWEST_BEAMS = 4
CREDIBLE = 7.0
"""Difference of log-likelihoods, nats, up to which a worse solution may be the true one."""
_SAME_M, _SAME_RAD = 0.02, 0.05
_UNDETERMINED_M = 0.03
"""Standard deviation along a direction, metres at the object's distance, from which it counts as not determined."""
_PARTS = 4


@dataclass(frozen=True)
class Undetermined:
    """Direction that scans do not determine: an eigenvector of the covariance of the lidar's pose about the object.

    Attributes:
        coordinate: its largest part: the bearing from which the object is seen, the distance, or the lidar's own turn.
        std: standard deviation along it, radians for a bearing or a turn, metres for a distance.
    """

    coordinate: Literal["bearing", "distance", "turn"]
    std: float


@dataclass(frozen=True, eq=False)
class Solution:
    """Estimate of the unknown pose under one sign of the yaw.

    Attributes:
        upside_down: True if the lidar hangs upside down.
        pose: (3,) mean of x, y (m) and yaw (rad).
        covariance: (3, 3) of that pose.
        fit: log-likelihood of the best sample, nats.
        undetermined: directions that the scans do not determine, at the first stop.
        sigma_m: standard deviation of the differences of measured and predicted ranges, metres.
        beams: number of beams on which the object was seen where it was predicted, of all stops.
    """

    upside_down: bool
    pose: Floats
    covariance: Floats
    fit: float
    undetermined: tuple[Undetermined, ...]
    sigma_m: float
    beams: int

    @property
    def std(self) -> Floats:
        """Standard deviations of x and y (m) and yaw (rad), (3,)."""
        return np.sqrt(np.diag(self.covariance))


class Search:
    """Search for the solutions under one sign of the yaw."""

    def __init__(
        self,
        stops: Sequence[Stop],
        unknown: Unknown,
        hangs: bool,
        range_max: float,
        noise_m: float,
        random: np.random.Generator,
    ) -> None:
        """Read the scans of all stops.

        Args:
            stops: of the robot, at least one.
            unknown: pose to be estimated.
            hangs: True for a lidar that hangs upside down.
            range_max: of the lidar, metres.
            noise_m: standard deviation of one range, metres, where the revolutions of a stop do not show it.
            random: generator of the samples.
        """
        self._stops = stops
        self._unknown = unknown
        self._hangs = hangs
        self._range_max = range_max
        self._noise_m = noise_m
        self._random = random
        self._all = self._measured(slice(None))
        self._centre = stops[0].target.centre

    def _measured(self, part: slice) -> list[Measured]:
        return [stop.measured(upside_down_lidar=self._hangs, part=part) for stop in self._stops]

    def solutions(self) -> list[Solution]:
        """Narrow down the best proposals, and return those that differ and fit about as well as the best."""
        proposed = proposals(self._all[0])
        if not len(proposed):
            return []
        fits = self._density(self._all, proposed, _COARSE_M)
        starts = _distinct(proposed, fits, _STARTS)
        clouds = [sampled(self._of_all, start, np.diag(START_STD**2), _STEPS_M, _FEW, self._random) for start in starts]
        best = max(clouds, key=lambda cloud: cloud.best_log, default=None)
        if best is None or best.best_log <= 0.0:
            return []
        sigma_m, beams = self._spread(best.best)
        if beams < _FEWEST_BEAMS:
            return []
        kept = [cloud for cloud in clouds if cloud.best_log >= best.best_log - CREDIBLE * 3.0]
        finals = [
            sampled(self._of_all, cloud.mean, 2.0 * cloud.covariance, (0.004, sigma_m, sigma_m), _MANY, self._random)
            for cloud in _distinct_clouds(kept)
        ]
        top = max(cloud.best_log for cloud in finals)
        return [self._solution(cloud, sigma_m, beams) for cloud in finals if cloud.best_log >= top - CREDIBLE]

    def _of_all(self, polar: Floats, sigma_m: float) -> Floats:
        return self._density(self._all, polar, sigma_m)

    def _density(self, measured: Sequence[Measured], polar: Floats, sigma_m: float) -> Floats:
        first = lidar_poses(polar, self._centre)
        logs = np.log(np.maximum(polar[:, 1], 1e-9))  # of the area of polar coordinates
        for index, each in enumerate(measured):
            lidars = self._unknown.lidars(first, index)
            logs = logs + log_likelihoods(each, lidars, sigma_m, self._range_max)
        return np.asarray(np.where(polar[:, 1] > 0.0, logs, -np.inf), dtype=np.float64)

    def _spread(self, polar: Floats) -> tuple[float, int]:
        """Estimate the standard deviation of the median ranges, metres, and count the beams on the object.

        The mean square of the differences is averaged with what the noise of successive revolutions predicts, which
        counts as four beams, so that few beams do not give a false certainty.
        """
        first = lidar_poses(polar[None, :], self._centre)
        off = np.concatenate(
            [
                residuals(each, self._unknown.lidars(first, index)[0], 4.0 * _STEPS_M[-1], self._range_max)
                for index, each in enumerate(self._all)
            ]
        )
        expected_m = max(self._median_noise_m(stop) for stop in self._stops)
        freedom = max(len(off) - 3.0, 0.0)
        square = (_PRIOR_BEAMS * expected_m**2 + float((off**2).sum())) / (_PRIOR_BEAMS + freedom)
        return max(_LEAST_SIGMA_M, math.sqrt(square)), len(off)

    def _median_noise_m(self, stop: Stop) -> float:
        """Standard deviation of the median of a stop's ranges, metres: that of a mean times sqrt(pi / 2)."""
        noise_m = self._noise_m if stop.noise_m is None else stop.noise_m
        return max(_LEAST_SIGMA_M, noise_m * math.sqrt(0.5 * math.pi / len(stop.scans)))

    def _solution(self, cloud: Cloud, sigma_m: float, beams: int) -> Solution:
        pose, covariance = self._pose(cloud)
        widened = self._widening(cloud, sigma_m, np.sqrt(np.diag(covariance)))
        return Solution(
            self._hangs,
            pose,
            covariance * np.outer(widened, widened) + self._offset(cloud),
            cloud.best_log,
            _undetermined(cloud),
            sigma_m,
            beams,
        )

    def _pose(self, cloud: Cloud) -> tuple[Floats, Floats]:
        """Mean and covariance of the unknown pose."""
        reference = self._unknown.of_lidar(lidar_poses(cloud.best[None, :], self._centre))[0]
        off = self._unknown.of_lidar(lidar_poses(cloud.samples, self._centre)) - reference
        off[:, 2] = wrapped(off[:, 2])
        mean = cloud.weights @ off
        covariance = ((off - mean) * cloud.weights[:, None]).T @ (off - mean)
        pose = reference + mean
        pose[2] = wrapped(pose[2:])[0]
        return pose, covariance

    def _offset(self, cloud: Cloud) -> Floats:
        """Covariance of the unknown pose because of an offset that all ranges of a stop share."""
        farther = np.stack([cloud.best, cloud.best + np.array([0.0, _OFFSET_M, 0.0])])
        near, far = self._unknown.of_lidar(lidar_poses(farther, self._centre))
        moved = far - near
        moved[2] = wrapped(moved[2:])[0]
        return np.asarray(np.outer(moved, moved) / len(self._stops), dtype=np.float64)

    def _widening(self, cloud: Cloud, sigma_m: float, std: Floats) -> Floats:
        """Factor of each standard deviation, at least 1, by which parts of the revolutions differ more than stated."""
        fewest = min(len(stop.scans) for stop in self._stops)
        if fewest < 2 * _PARTS:
            return np.ones(3)
        poses = []
        for part in range(_PARTS):
            measured = self._measured(slice(part, None, _PARTS))
            own = sampled(
                partial(self._density, measured),
                cloud.mean,
                4.0 * cloud.covariance,
                (1.5 * sigma_m, 1.5 * sigma_m),
                _FEW,
                self._random,
            )
            poses.append(self._pose(own)[0])
        off = np.array(poses) - poses[0]
        off[:, 2] = wrapped(off[:, 2])
        between = off.std(axis=0, ddof=1) / math.sqrt(_PARTS)
        return np.asarray(np.maximum(1.0, between / std), dtype=np.float64)


def _undetermined(cloud: Cloud) -> tuple[Undetermined, ...]:
    """List the directions of a distribution whose standard deviation at the object's distance is above 3 cm."""
    scale = np.array([cloud.best[1], 1.0, cloud.best[1]])
    values, vectors = np.linalg.eigh(cloud.covariance * np.outer(scale, scale))
    names: tuple[Literal["bearing", "distance", "turn"], ...] = ("bearing", "distance", "turn")
    result = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value > _UNDETERMINED_M**2:
            largest = int(np.argmax(np.abs(vector)))
            result.append(Undetermined(names[largest], math.sqrt(cloud.covariance[largest, largest])))
    return tuple(result)


def _distinct(polar: Floats, fits: Floats, most: int) -> list[Floats]:
    """Choose the best proposals that differ from one another."""
    chosen: list[Floats] = []
    for index in np.argsort(-fits):
        if len(chosen) == most or fits[index] <= 0.0:
            break
        if all(_differ(polar[index], other, _APART) for other in chosen):
            chosen.append(polar[index])
    return chosen


def _distinct_clouds(clouds: Sequence[Cloud]) -> list[Cloud]:
    """Choose the best of the clouds that have come to the same place."""
    chosen: list[Cloud] = []
    for cloud in sorted(clouds, key=lambda each: -each.best_log):
        spread = np.sqrt(np.diag(cloud.covariance))
        apart = np.array([_SAME_RAD, _SAME_M, _SAME_RAD]) + 2.0 * spread
        if all(_differ(cloud.mean, other.mean, apart) for other in chosen):
            chosen.append(cloud)
    return chosen


def _differ(one: Floats, other: Floats, apart: Floats) -> bool:
    off = one - other
    off[[0, 2]] = wrapped(off[[0, 2]])
    return bool((np.abs(off) > apart).any())
