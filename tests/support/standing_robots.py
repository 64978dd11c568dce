"""Recordings of a simulated robot that stands before an object at a known pose: noisy scans, walls, odometry."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.voa_recordings.files.bags import START_NS, STEP_NS, Written, laser_scan, mcap
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_recordings.files.ros_types import LASER_SCAN, ODOMETRY
from voa_ros.cdr import encode_laser_scan, encode_odometry
from voa_ros.grids import upside_down
from voa_ros.messages import Odometry, Pose, Stamp
from voa_ros.motions import Motion, composed, inverse

GRID = BeamGrid(360, 0.0, math.radians(1.0))
WALLS_M = 2.0
"""Distance of the walls, square, from the origin of the world."""


@dataclass(frozen=True)
class Standing:
    """A robot that stands still: true pose of its lidar in the world, pose by odometry, and the object's pose."""

    lidar: Motion
    odometry: Motion
    pose: str
    revolutions: int = 12


@dataclass(frozen=True)
class Bench:
    """Object with named poses before a lidar of 360 beams, in a room with four walls."""

    mesh: Object
    poses: PoseSet
    height_m: float

    def ranges(self, lidar: Motion, pose: str) -> NDArray[np.float64]:
        """Exact ranges of one revolution, metres, of a lidar that stands upright."""
        model = LidarModel(GRID, 0.0, 3.5, self.height_m, "missing", 1e-3, 0.0, 0.0)
        sensor = SensorConfiguration("lidar", lidar.x, lidar.y, lidar.yaw_rad)
        predicted = predictor_of_mesh(self.mesh, self.poses, model).predict(sensor).dense()
        angles = lidar.yaw_rad + GRID.angles
        with np.errstate(divide="ignore"):
            walls = np.minimum(
                (WALLS_M - np.sign(np.cos(angles)) * lidar.x) / np.abs(np.cos(angles)),
                (WALLS_M - np.sign(np.sin(angles)) * lidar.y) / np.abs(np.sin(angles)),
            )
        return np.asarray(np.minimum(predicted[self.poses.names.index(pose)], walls), dtype=np.float64)


def prism(outline: Sequence[tuple[float, float]], height_m: float = 0.1) -> Object:
    """An upright prism on the table; `outline` counter-clockwise, seen from its first corner without hidden parts."""
    count = len(outline)
    vertices = [(x, y, z) for z in (0.0, height_m) for x, y in outline]
    sides = [[i, (i + 1) % count, count + i] for i in range(count)]
    sides += [[(i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
    caps = [[0, i + 1, i] for i in range(1, count - 1)] + [
        [count, count + i, count + i + 1] for i in range(1, count - 1)
    ]
    return Object.from_arrays(vertices, sides + caps)


def bench_of(mesh: Object) -> Bench:
    """A mesh that stands upright at the origin of the world, pose "as made"; the scan plane is at 5 cm."""
    return Bench(mesh, PoseSet.from_arrays(["as made"], [[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]]), 0.05)


CORNER = ((0.0, 0.0), (0.12, 0.0), (0.12, 0.03), (0.03, 0.03), (0.03, 0.07), (0.0, 0.07))
"""Outline of an angle bracket with two different legs, which has no symmetry; metres."""


def messages(
    bench: Bench,
    stops: Sequence[Standing],
    noise: np.random.Generator,
    *,
    noise_m: float = 0.003,
    hangs: bool = False,
    topic: str = "/tb3_1/scan",
) -> list[Written]:
    """Scans and odometry of a robot that stands at each of the places in turn, one revolution each 0.2 s."""
    made: list[Written] = []
    for stop in stops:
        exact = bench.ranges(stop.lidar, stop.pose)
        for _ in range(stop.revolutions):
            at = START_NS + len(made) // 2 * STEP_NS
            stamp = Stamp(at // 1_000_000_000, at % 1_000_000_000)
            odometry = Odometry(
                stamp, "odom", "base", Pose.planar(stop.odometry.x, stop.odometry.y, stop.odometry.yaw_rad)
            )
            ranges = exact + noise.normal(0.0, noise_m, len(exact))
            scan = laser_scan(ranges.tolist(), at, angle_increment=GRID.angle_increment)
            if hangs:
                turned = upside_down(scan)
                scan = replace(scan, ranges=(turned.ranges[-1:] + turned.ranges[:-1]))  # angle 0 first again
            made.append(("/tb3_1/odom", ODOMETRY, at, encode_odometry(odometry)))
            made.append((topic, LASER_SCAN, at, encode_laser_scan(scan)))
    return made


def write(path: Path, made: Sequence[Written]) -> Path:
    """Write messages into an MCAP file."""
    return mcap(path, made)


def robot_of(lidar: Motion, mount: Motion, origin: Motion) -> Motion:
    """Pose of the robot by odometry, from the true pose of its lidar: inverse(origin) lidar inverse(mount)."""
    return composed(composed(inverse(origin), lidar), inverse(mount))


def facing(bearing_rad: float, distance_m: float, turned_rad: float = 0.0) -> Motion:
    """Pose of a lidar around the world's origin; `turned_rad` away from looking at it."""
    return Motion(
        distance_m * math.cos(bearing_rad), distance_m * math.sin(bearing_rad), bearing_rad + math.pi + turned_rad
    )
