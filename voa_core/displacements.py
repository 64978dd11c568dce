"""Small planar displacements of the object: the poses that a listed pose stands for, and how a lidar sees them.

The object never lies exactly at a listed pose, and a robot never stands exactly where it says. Both errors displace the
object in the plane relative to the lidar, so one displacement (x, y, yaw) stands for both. Each pose has J displaced
copies: J points of a standard normal distribution, scaled by the root of the covariance of that pose.
"""

import hashlib
import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from voa_core.checks import Floats, frozen, number
from voa_core.cutting import Contours
from voa_core.errors import InvalidInput, NoMesh
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet

_USUAL, _MANY, _FEWEST = 64, 256, 16
_LARGE_M, _LARGE_RAD = 0.02, math.radians(6.0)
_MOST_COPIES = 1_300_000
_SLACK = 1.0 + 1e-9  # standard deviations are roots of squares
_SINGULAR = 1e-12


@dataclass(frozen=True)
class Spread:
    """Standard deviations of the object from a listed pose: of each of x and y, in metres, and of the yaw, in radians.

    Raises:
        InvalidInput: a standard deviation is negative or not finite, or both are 0.
    """

    xy_m: float
    yaw_rad: float

    def __post_init__(self) -> None:
        number("xy_m", self.xy_m, at_least=0.0)
        number("yaw_rad", self.yaw_rad, at_least=0.0)
        if self.xy_m == 0.0 and self.yaw_rad == 0.0:
            raise InvalidInput("spread", "xy_m or yaw_rad above 0, or no spread", "both 0")


def covariances(
    poses: PoseSet, sensor: SensorConfiguration, spread: Spread | None, std: SensorUncertainty | None
) -> Floats:
    """Covariances C_a of the displacement (x, y, yaw) of each pose relative to the sensor, (n, 3, 3).

    C_a = C_o + A_a C_s A_a^T: the object's own spread, and the error of the sensor pose seen as a displacement of
    the object. A sensor that is moved by (dx, dy) and turned by t about itself sees an object at (x_p, y_p) as if it
    were moved by -(dx, dy), and turned by -t about the sensor.

    Args:
        poses: the poses that are displaced, about their own positions.
        sensor: the stated sensor pose, which does not move.
        spread: of the object about a listed pose; None: it lies exactly there.
        std: of the sensor pose; None: it is exact.

    Raises:
        NoMesh: the poses have no positions, and the sensor's yaw is uncertain.
    """
    of_object = np.zeros((3, 3)) if spread is None else np.diag([spread.xy_m**2, spread.xy_m**2, spread.yaw_rad**2])
    covariance = np.repeat(of_object[None], len(poses), axis=0)
    if std is None or (std.xy_m == 0.0 and std.yaw_rad == 0.0):
        return covariance
    if poses.positions is None:
        raise NoMesh("the poses have names only; an uncertain sensor pose needs their positions")
    seen = np.repeat(-np.eye(3)[None], len(poses), axis=0)  # A_a
    seen[:, 0, 2] = poses.positions[:, 1] - sensor.y
    seen[:, 1, 2] = sensor.x - poses.positions[:, 0]
    of_sensor = np.diag([std.xy_m**2, std.xy_m**2, std.yaw_rad**2])
    return covariance + seen @ of_sensor @ seen.transpose(0, 2, 1)


def displacement_count(covariance: Floats) -> int:
    """Number J of displaced copies of each pose that a look needs, from its covariances (n, 3, 3).

    It is 1 where nothing is uncertain, else 64, or 256 where at some pose a standard deviation exceeds 2 cm or 6
    degrees. It is halved until n J is at most 1 300 000, but not below 16.
    """
    std = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    if not std.any():
        return 1
    large = (std > np.array([_LARGE_M, _LARGE_M, _LARGE_RAD]) * _SLACK).any()
    count = _MANY if large else _USUAL
    while count > _FEWEST and count * len(covariance) > _MOST_COPIES:
        count //= 2
    return count


@lru_cache(maxsize=16)
def standard_normal_points(count: int, seed: str, scramble: str = "update") -> Floats:
    """Make points of the standard normal distribution in three dimensions, (count, 3), that fill it evenly.

    They are the first points of a scrambled Sobol sequence, so that more points begin with the fewer. A single point
    is the origin.

    Args:
        count: a power of two.
        seed: names the sequence; the same seed gives the same points.
        scramble: names the use of the points: another use of the same seed has other points.

    Raises:
        InvalidInput: the count is no power of two.
    """
    from scipy.special import ndtri  # noqa: PLC0415 - slow to import, and needed for this alone
    from scipy.stats.qmc import Sobol  # noqa: PLC0415

    if count < 1 or count & (count - 1):
        raise InvalidInput("count", "a power of two", str(count))
    if count == 1:
        return frozen(np.zeros((1, 3)))
    digest = hashlib.sha256(f"{scramble}\n{seed}".encode()).digest()
    generator = np.random.default_rng(int.from_bytes(digest[:16], "big"))
    sequence = Sobol(3, scramble=True, rng=generator)
    inside = sequence.random(count) + 0.5 ** (sequence.bits + 1)  # the middle of each cell: never 0
    points: Floats = ndtri(inside)
    return frozen(points)


def lower_roots(covariance: Floats) -> Floats:
    """Lower triangular roots L of covariances, (n, 3, 3), with L L^T = C; a covariance may be singular.

    A column is 0 where the variance that remains is rounding.
    """
    roots = np.zeros_like(covariance)
    for column in range(3):
        remaining = covariance[:, column:, column] - np.einsum(
            "nik,nk->ni", roots[:, column:, :column], roots[:, column, :column]
        )
        pivot = remaining[:, 0]
        regular = pivot > _SINGULAR * covariance[:, column, column]
        scale = np.sqrt(np.where(regular, pivot, 1.0))
        roots[:, column:, column] = np.where(regular[:, None], remaining / scale[:, None], 0.0)
    return roots


def scaled(points: Floats, covariance: Floats) -> Floats:
    """Scale standard-normal points (J, 3) by the covariances of the poses (n, 3, 3): displacements (n, J, 3)."""
    displacements: Floats = points @ lower_roots(covariance).transpose(0, 2, 1)
    return displacements


def displaced(contours: Contours, displacements: Floats, first: int = 0) -> Contours:
    """Place the cuts of poses once for each displacement; no cut is made again.

    A displacement turns a pose about its own position, and moves it.

    Args:
        contours: the cuts of all poses.
        displacements: (k, J, 3) x and y in metres, yaw in radians, of k poses in their order.
        first: index of the first of these poses.

    Returns:
        The cuts of k * J poses: all copies of the first pose, then those of the next.
    """
    count, copies = displacements.shape[:2]
    poses = np.repeat(np.arange(first, first + count), copies)
    x, y, yaw = displacements.reshape(-1, 3).T
    cos, sin = np.cos(yaw), np.sin(yaw)
    placement = contours.placement[poses]
    turned = placement[:, 0] * cos - placement[:, 1] * sin, placement[:, 0] * sin + placement[:, 1] * cos
    moved = np.column_stack([*turned, placement[:, 2] + x, placement[:, 3] + y])
    return replace(contours, cut_of_pose=contours.cut_of_pose[poses], placement=moved)


@dataclass(frozen=True)
class Displacements:
    """Displaced copies of every pose as one look needs them.

    Attributes:
        copies: number J of copies of each pose, a power of two; a single one is not displaced.
        spread: of the object about a listed pose; None: it lies exactly there.
        std: of the sensor pose; None: it is exact.
        seed: names the points, see `standard_normal_points`.
    """

    copies: int
    spread: Spread | None
    std: SensorUncertainty | None
    seed: str

    @classmethod
    def of(
        cls,
        poses: PoseSet,
        sensor: SensorConfiguration,
        spread: Spread | None,
        std: SensorUncertainty | None,
        seed: str,
        at_least: int = 1,
    ) -> "Displacements":
        """Make the displacements of a look from `sensor`, with as many copies as its uncertainty needs.

        Args:
            poses: the poses that are displaced.
            sensor: the stated sensor pose.
            spread: of the object; None: it lies exactly at a pose.
            std: of the sensor pose; None: it is exact.
            seed: names the points.
            at_least: copies that the look's place has already; without any uncertainty one copy serves all.

        Raises:
            NoMesh: the poses have no positions, and the sensor pose is uncertain.
        """
        if spread is None and (std is None or std.xy_m == std.yaw_rad == 0.0):
            return cls(1, None, None, seed)
        needed = displacement_count(covariances(poses, sensor, spread, std))
        return cls(max(needed, at_least), spread, std, seed)

    def at(self, poses: PoseSet, sensor: SensorConfiguration) -> Floats:
        """Displacements of the poses relative to the sensor, (n, J, 3): x and y in metres, yaw in radians."""
        points = standard_normal_points(self.copies, self.seed)
        return scaled(points, covariances(poses, sensor, self.spread, self.std))
