"""Simulated scans: what a noisy lidar may measure of an object that lies near a listed pose.

Each pose gives K scans at each place. A scan is the prediction of a displaced copy of the pose with the range noise of
the lidar, classified as a measured scan is. The displacement has two parts: the object's own, the same for all places
of a sample, and the error of the sensor pose, of its own for each place. At a place that was already looked from, the
displacement follows the weighted displacements of that place instead.

The random numbers depend on the scenario's seed, on the names of the poses and on the place alone, so that a request
has one answer, and another order of poses or places the same answers in that order.
"""

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.displacements import Spread, covariances, lower_roots
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import Prediction
from voa_core.scans import MISSING, NO_RETURN
from voa_core.workspace import Crossing

SCANS_OF_A_PLACE = 256
"""Fewest simulated scans of a place, over all poses."""
FRESH = 4
"""Factor by which the best look is evaluated on more scans once more."""
_DIMENSIONS = 7  # the object's displacement, the sensor's, and the choice among weighted displacements
_SMOOTHING = 1.2  # in standard deviations, of the distance between J points in three dimensions, times J^(1/3)


def samples_per_pose(poses: int) -> int:
    """Number K of simulated scans of each of so many poses at a place: 256 scans in all, and at least one each."""
    return math.ceil(SCANS_OF_A_PLACE / poses)


@dataclass(frozen=True)
class Sampling:
    """Choice of the random numbers of simulated scans.

    Attributes:
        seed: names the scenario; the same seed gives the same scans.
        samples: number K of scans of each pose, at least 1.
        scramble: names the use of the scans: another use has other random numbers.
    """

    seed: str
    samples: int
    scramble: str = "value"

    def fresh(self) -> "Sampling":
        """Sampling with four times as many scans of each pose, and other random numbers."""
        return Sampling(self.seed, FRESH * self.samples, "fresh value")

    def uniforms(self, poses: PoseSet, place: str) -> Floats:
        """Make points (n, K, 7) that fill the unit cube evenly for each pose: a Sobol sequence, shifted at random.

        The first three coordinates, of the object, are the same at all places; the others are shifted for each place.
        """
        from scipy.stats.qmc import Sobol  # noqa: PLC0415 - slow to import, and needed for this alone

        power = math.ceil(math.log2(self.samples))
        points = Sobol(_DIMENSIONS, scramble=False).random_base2(power)[: self.samples]
        shifts = np.concatenate(
            [
                self._generator("object").random((len(poses), 3)),
                self._generator("place", place).random((len(poses), 4)),
            ],
            axis=1,
        )
        uniforms: Floats = np.remainder(points + shifts[_ranks(poses)][:, None, :], 1.0)
        return uniforms

    def noise(self, poses: PoseSet, place: str, look: int, beams: int) -> Floats:
        """Make standard-normal range noise of the beams, (n, K, beams), for one of several looks from a place."""
        drawn = self._generator("noise", place, str(look)).standard_normal((len(poses), self.samples, beams))
        noise: Floats = drawn[_ranks(poses)]
        return noise

    def _generator(self, *use: str) -> np.random.Generator:
        text = "\n".join((self.seed, self.scramble, *use))
        return np.random.default_rng(int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "big"))


def _ranks(poses: PoseSet) -> NDArray[np.intp]:
    """Rank of each pose's name, (n,): random numbers belong to names, so that the order of the poses has no effect."""
    ranks = np.zeros(len(poses), dtype=np.intp)
    ranks[np.argsort(np.array(poses.names), kind="stable")] = np.arange(len(poses))
    return ranks


def name_of_place(sensor: SensorConfiguration, *, listed: bool) -> str:
    """Text that names a place whatever its cost: its pose, with its name where the scenario lists it."""
    return repr((sensor.name if listed else None, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m))


def drawn_displacements(
    uniforms: Floats,
    poses: PoseSet,
    sensor: SensorConfiguration,
    spread: Spread | None,
    std: SensorUncertainty | None,
) -> Floats:
    """Draw displacements (n, K, 3), x and y in metres and yaw in radians, from points of the unit cube (n, K, 7).

    Raises:
        NoMesh: the poses have no positions, and the sensor's yaw is uncertain.
    """
    from scipy.special import ndtri  # noqa: PLC0415 - slow to import, and needed for this alone

    normal = ndtri(_inside(uniforms[:, :, :6]))
    of_object = lower_roots(covariances(poses, sensor, spread, None))
    of_sensor = lower_roots(covariances(poses, sensor, None, std))
    by_object = normal[:, :, :3] @ of_object.transpose(0, 2, 1)
    by_sensor = normal[:, :, 3:] @ of_sensor.transpose(0, 2, 1)
    displacements: Floats = by_object + by_sensor
    return displacements


def chosen_displacements(uniforms: Floats, displacements: Floats, log_sums: Floats) -> Floats:
    """Draw K displacements of each pose near the J displacements (n, J, 3), by their weights at a place looked from.

    The true displacement lies between the points, not at one. A scan of one of the very copies with which the update
    compares would promise too much, so each chosen displacement d gives mean + sqrt(1 - h^2) (d - mean) + h z, with z
    of the covariance of the J points and h of the order of their distances. Where all weigh alike, this has the mean
    and the covariance of the points again.

    Args:
        uniforms: (n, K, 7) points of the unit cube; the last coordinate chooses, the three before it give z.
        displacements: of the update at this place.
        log_sums: (n, J) log weights of the place's looks, summed. Where all are -inf, each is as likely as another.

    Returns:
        Shape (n, K, 3).
    """
    from scipy.special import ndtri  # noqa: PLC0415 - slow to import, and needed for this alone

    cumulative = np.cumsum(shares_of_copies(log_sums), axis=1)
    index = (uniforms[:, :, 6, None] * cumulative[:, None, -1:] >= cumulative[:, None, :]).sum(axis=2)
    copies = displacements.shape[1]
    chosen = np.take_along_axis(displacements, np.minimum(index, copies - 1)[:, :, None], axis=1)
    means = displacements.mean(axis=1, keepdims=True)
    off = displacements - means
    roots = lower_roots(np.einsum("nja,njb->nab", off, off) / copies)
    share = min(1.0, _SMOOTHING * copies ** (-1.0 / 3.0))
    near: Floats = (
        means
        + math.sqrt(1.0 - share**2) * (chosen - means)
        + share * np.einsum("nab,nkb->nka", roots, ndtri(_inside(uniforms[:, :, 3:6])))
    )
    return near


def _inside(uniforms: Floats) -> Floats:
    """Move points of the unit cube off its faces, where the normal distribution has no quantile."""
    return np.clip(uniforms, 2.0**-53, 1.0 - 2.0**-53)


def shares_of_copies(log_sums: Floats) -> Floats:
    """Probability of each displaced copy of each pose given the looks from a place, from their log sums, (n, J)."""
    highest = log_sums.max(axis=1, keepdims=True)
    impossible = highest == -np.inf
    weights = np.exp(np.where(impossible, 0.0, log_sums) - np.where(impossible, 0.0, highest))
    shares: Floats = weights / weights.sum(axis=1, keepdims=True)
    return shares


def simulated_ranges(prediction: Prediction, noise: Floats, lidar: LidarModel, crossing: Crossing | None) -> Floats:
    """Add range noise to predicted scans and classify the beams as `scans.classify` does those of measured ones.

    The standard deviation of a range is the larger of the lidar's `noise_m` and `noise_ratio` times the range.

    Args:
        prediction: of displaced poses by geometry alone, N scans on c columns.
        noise: (N, c) standard-normal.
        lidar: its noise and limits apply.
        crossing: distances at which the c columns cross the workspace; None: there is no workspace.

    Returns:
        Shape (N, c), metres; inf for a no-return and NaN for a missing beam.
    """
    exact = prediction.ranges
    hit = np.isfinite(exact)
    near = np.where(hit, exact, 0.0)
    ranges = np.where(hit, near + noise * np.maximum(lidar.noise_m, lidar.noise_ratio * near), NO_RETURN)
    ranges = np.where(ranges < lidar.range_min, MISSING, np.where(ranges > lidar.range_max, NO_RETURN, ranges))
    if crossing is not None:
        returned = np.isfinite(ranges)
        before = returned & crossing.before(ranges)
        ranges = np.where(returned & ~before & ~crossing.inside(ranges), NO_RETURN, ranges)
        ranges = np.where(before, MISSING, ranges)
    return ranges
