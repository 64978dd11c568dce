"""The world of the table: an object that lies near a listed pose, a robot that errs, and a lidar with noise."""

import math
from dataclasses import dataclass, field

import numpy as np
import trimesh

from tests.acceptance.casting import Floats, box, cast, cut, matrix_of, turned, window
from voa_client import PoseUncertainty, Scan, SensorPose, UncertainSensorPose

SPREAD_M, SPREAD_RAD = 0.005, math.radians(3.0)
"""Standard deviations of the object from its listed pose, which scenarios state as their spread."""
EXACT = PoseUncertainty(xy_m=0.0, yaw_rad=0.0)


@dataclass(frozen=True)
class Noise:
    """Noise of a lidar.

    Attributes:
        near_m: standard deviation of a range up to `far_from_m`, metres.
        far_share: standard deviation of a longer range, as a share of it.
        far_from_m: metres.
        lost: share of beams that are lost.
        step_m: resolution of a range, metres.
    """

    near_m: float = 0.003
    far_share: float = 0.03
    far_from_m: float = 0.5
    lost: float = 0.04
    step_m: float = 0.001

    def measure(self, ranges: Floats, rng: np.random.Generator) -> Floats:
        """Measure true ranges (inf: nothing in range); NaN for a lost beam."""
        hit = np.isfinite(ranges)
        true = np.where(hit, ranges, 0.0)
        std = np.where(true > self.far_from_m, self.far_share * true, self.near_m)
        measured = np.maximum(
            0.0, np.round((true + rng.standard_normal(ranges.shape) * std) / self.step_m) * self.step_m
        )
        return np.where(rng.random(ranges.shape) < self.lost, np.nan, np.where(hit, measured, np.inf))


@dataclass(frozen=True)
class Lidar:
    """A lidar: its preset in scenarios (None: the numbers below), its beams and range, metres and radians."""

    preset: str | None = "lds-01"
    beams: int = 360
    angle_min: float = 0.0
    angle_increment: float = math.radians(1.0)
    range_max: float = 3.5

    @property
    def angles(self) -> Floats:
        """Directions of the beams, (beams,) radians from the sensor's +x."""
        return self.angle_min + self.angle_increment * np.arange(self.beams, dtype=np.float64)


@dataclass(frozen=True)
class Pose:
    """A listed pose: name, position (metres) and quaternion w, x, y, z."""

    name: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


@dataclass(frozen=True)
class Place:
    """A place of the table: name, stated sensor pose with its height (metres, radians), and cost of a look."""

    name: str
    x: float
    y: float
    yaw_rad: float
    height_m: float
    cost: float = 0.0


@dataclass(eq=False)
class World:
    """An object, its listed poses, places, and the lidar and room in which it is looked at.

    Attributes:
        mesh: of the object, metres.
        poses: n listed poses.
        places: from which the lidar looks.
        scores: (m, n) success probability of each grasp at each pose.
        walls: (k, 2, 2) segments of the room, metres.
    """

    name: str
    mesh: trimesh.Trimesh
    poses: list[Pose]
    places: list[Place]
    scores: Floats
    walls: Floats = field(default_factory=lambda: box((-1.7, -1.4), (1.5, 1.9)))
    lidar: Lidar = Lidar()
    noise: Noise = Noise()
    cuts: dict[tuple[int, float], Floats] = field(default_factory=dict)

    def ranges(self, pose: int, place: Place, moved: Floats, strayed: Floats) -> Floats:
        """Ranges without noise of scans of the object near a pose, from near a place, (N, beams) metres.

        Args:
            pose: index of the listed pose.
            place: where the robot believes to be.
            moved: (N, 3) displacement of the object: x, y, metres, and yaw about its position, radians.
            strayed: (N, 3) error of the robot: where it is less where it believes to be, x, y and yaw.
        """
        height = place.height_m
        if (pose, height) not in self.cuts:
            listed = self.poses[pose]
            self.cuts[pose, height] = cut(self.mesh, matrix_of(listed.quaternion), listed.position[2], height)
        segments, angles = self.cuts[pose, height], self.lidar.angles
        sensor, heading = strayed[:, :2] + (place.x, place.y), strayed[:, 2] + place.yaw_rad
        ranges = cast(self.walls, sensor, heading[:, None] + angles)
        # Instead of the object the sensor moves, into the frame of the cut.
        away = sensor - moved[:, :2] - np.array(self.poses[pose].position[:2])
        origin = np.einsum("nab,nb->na", turned(-moved[:, 2]), away)
        beams = window(segments, origin, heading - moved[:, 2], angles)
        of_object = cast(segments, origin, (heading - moved[:, 2])[:, None] + angles[beams])
        ranges[:, beams] = np.minimum(ranges[:, beams], of_object)
        return np.where(ranges > self.lidar.range_max, np.inf, ranges)

    def scans(self, pose: int, place: Place, moved: Floats, strayed: Floats, rng: np.random.Generator) -> list[Scan]:
        """Take scans of the object near a pose, from near a place; see `ranges`."""
        measured = self.noise.measure(self.ranges(pose, place, moved, strayed), rng)
        return [scan_of(row) for row in measured]


def scan_of(measured: Floats) -> Scan:
    """Convert measured ranges (beams,), inf for a no-return and NaN for a lost beam, to the message."""
    ranges = [float(value) if math.isfinite(value) else None for value in measured]
    return Scan(ranges=ranges, no_return=[int(index) for index in np.flatnonzero(np.isposinf(measured))])


def displacements(count: int, rng: np.random.Generator) -> Floats:
    """Displacements of the object from its listed pose, (count, 3): x, y, metres, and yaw, radians."""
    return rng.standard_normal((count, 3)) * (SPREAD_M, SPREAD_M, SPREAD_RAD)


def errors(count: int, std: PoseUncertainty, rng: np.random.Generator) -> Floats:
    """Errors of a robot's pose, (count, 3): x, y, metres, and yaw, radians."""
    return rng.standard_normal((count, 3)) * (std.xy_m, std.xy_m, std.yaw_rad)


def stated(place: Place, std: PoseUncertainty) -> SensorPose | UncertainSensorPose:
    """Sensor pose of a place as the robot states it, with its standard deviations unless they are 0."""
    return UncertainSensorPose(
        x=place.x, y=place.y, yaw_rad=place.yaw_rad, height_m=place.height_m, std=None if std == EXACT else std
    )
