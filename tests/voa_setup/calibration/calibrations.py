"""Random calibrations of a simulated robot before an angle bracket, whose outline has no symmetry."""

import math
from pathlib import Path

import numpy as np

from tests.support.standing_robots import (
    CORNER,
    GRID,
    Bench,
    Standing,
    bench_of,
    facing,
    messages,
    prism,
    robot_of,
    write,
)
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_ros.motions import Motion
from voa_ros.robots import RobotMapping, load
from voa_setup.calibration.estimating import Estimate, estimate
from voa_setup.calibration.known_object import Scene
from voa_setup.calibration.planar import Floats, planar, wrapped
from voa_setup.calibration.stops import Stop, stops_of
from voa_setup.calibration.unknowns import Estimated, Unknown

NOISE_M = 0.01
"""Noise that the lidar's preset states; the simulated lidar has 3 mm."""


def bracket() -> Bench:
    return bench_of(prism(CORNER))


def scene_of(bench: Bench) -> Scene:
    return Scene(bench.mesh, bench.poses, GRID, 3.5, bench.height_m, NOISE_M)


def mapping(place: str = 'place = { from = "odometry" }') -> RobotMapping:
    return load(f'[[robot]]\nname = "tb3_1"\nsession = "live"\n{place}\n')[0]


def random_pose(random: np.random.Generator, most_m: float) -> Motion:
    x, y = random.uniform(-most_m, most_m, 2)
    return Motion(x, y, random.uniform(-math.pi, math.pi))


def random_stops(
    bench: Bench, mount: Motion, origin: Motion, count: int, random: np.random.Generator
) -> list[Standing]:
    """Stops 0.3 to 0.5 m from the object, at any side, the lidar turned anywhere."""
    centre = scene_of(bench).at("as made", None).centre
    stops = []
    for _ in range(count):
        seen = facing(random.uniform(-math.pi, math.pi), random.uniform(0.3, 0.5), random.uniform(-math.pi, math.pi))
        lidar = Motion(seen.x + centre[0], seen.y + centre[1], seen.yaw_rad)
        stops.append(Standing(lidar, robot_of(lidar, mount, origin), "as made"))
    return stops


def recorded_stops(
    folder: Path, bench: Bench, stops: list[Standing], random: np.random.Generator, *, hangs: bool = False
) -> list[Stop]:
    """Stops as they are taken from a recording of the robot."""
    file = write(folder / "run.mcap", messages(bench, stops, random, hangs=hangs))
    scene = scene_of(bench)
    return stops_of(Recording(file, RosTypes()), mapping(), scene.at("as made", None), scene.grid)


def calibrated(
    stops: list[Stop], estimated: Estimated, origin: Floats, mount: Floats, *, within_m: float = math.inf
) -> Estimate:
    unknown = Unknown(estimated, origin, mount, [stop.robot for stop in stops])
    return estimate(stops, unknown, stated_upside_down=False, range_max=3.5, noise_m=NOISE_M, within_m=within_m, seed=0)


def in_deviations(result: Estimate, truth: Motion) -> Floats:
    """Errors of x, y and yaw in stated standard deviations, (3,)."""
    off = result.best.pose - planar(truth)
    off[2] = wrapped(off[2:])[0]
    return np.abs(off) / result.best.std
