"""Scans of the evaluated world: drawn here, independently of the scans that the service simulates for its rankings.

The object lies off its listed pose by a normal error, the robot stands off its stated pose, the lidar's ranges are
noisy and some of its beams are lost. These errors share neither random numbers nor noise with `voa_core.simulation`.
"""

import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.copies import SimulatedScans
from voa_core.lidars import LidarModel, SensorConfiguration
from voa_core.scan_model import ScanModel
from voa_core.scans import MISSING, NO_RETURN
from voa_core.simulation import Sampling
from voa_core.workspace import Crossing
from voa_evaluation.values.setting import SPREAD_XY_M, SPREAD_YAW_RAD, RobotError

NEAR_NOISE_M, FAR_NOISE_RATIO, FAR_M = 0.003, 0.03, 0.5
"""Standard deviation of a range close by, and its share of the range beyond a distance."""
LOST_BEAMS = 0.04
"""Share of the beams of a scan that are lost."""
_SETS_OF_LOST_BEAMS = 32  # scans share these sets, so that those with equal sets are compared at once
_MARGIN_BEAMS = 3


def random_source(seed: int, *names: str | int) -> np.random.Generator:
    """Make a random generator that depends on a seed and on names and numbers, in order."""
    return np.random.default_rng(
        [seed, *(part if isinstance(part, int) else zlib.crc32(part.encode()) for part in names)]
    )


@dataclass(frozen=True, eq=False)
class WorldScans(ScanModel):
    """Scans of the evaluated world in place of simulated ones, weighed by the update that runs.

    `SimulatedWeights.of` weighs the scans of any `ScanModel`; this one draws them from the world.

    Attributes:
        object: name of the object, which names its random numbers.
        world_seed: of all errors.
        error: of the robot; by what it states, `std`, the scans are weighed.
        robots: number of the robot that takes each of several looks in a row; robots have errors of their own.
    """

    object: str = ""
    world_seed: int = 0
    error: RobotError = field(default_factory=lambda: RobotError(0.0, 0.0))
    robots: tuple[int, ...] = (0,)

    def scans(
        self,
        sensor: SensorConfiguration,
        sampling: Sampling,
        *,
        listed: bool,  # noqa: ARG002 - objects of the fleet have meshes, and no data predictions
        looks: int = 1,
        displacements: Floats | None = None,  # noqa: ARG002 - the world does not know the update's
        log_sums: Floats | None = None,  # noqa: ARG002
    ) -> tuple[SimulatedScans, ...]:
        """Draw scans in a row of `sampling.samples` samples of every pose from one place.

        A sample has one displacement of the object, whatever the place, and each robot one error at each place.
        """
        robots = [self.robots[min(look, len(self.robots) - 1)] for look in range(looks)]
        return tuple(self._scans(sensor, sampling.samples, look, robot) for look, robot in enumerate(robots))

    def _scans(self, sensor: SensorConfiguration, samples: int, look: int, robot: int) -> SimulatedScans:
        apart = self._displacements(sensor, samples, robot)
        prediction = self.predictor.predict_displaced(sensor, apart)
        angles = prediction.grid.angles
        noise = self._random("noise", sensor.name, robot, look)
        lost = noise.random((_SETS_OF_LOST_BEAMS, prediction.grid.beams)) < LOST_BEAMS
        group = noise.integers(0, _SETS_OF_LOST_BEAMS, len(prediction.ranges))
        columns = _widened(prediction.columns, prediction.grid.beams)
        exact = prediction.dense()[:, columns]
        crossing = None if self.workspace is None else self.workspace.crossing(sensor, angles[columns])
        ranges = measured_ranges(exact, noise.standard_normal(exact.shape), self.lidar, crossing)
        ranges[lost[group][:, columns]] = MISSING
        return SimulatedScans.of(columns, ranges, prediction.grid.beams)

    def _displacements(self, sensor: SensorConfiguration, samples: int, robot: int) -> Floats:
        """Displacements (n, S, 3) of the object as a robot sees it that believes to stand at `sensor`."""
        positions = self.poses.positions
        if positions is None:
            raise ValueError("the poses have names only: expected positions, as all objects of the fleet have")
        shape = len(self.poses), samples, 3
        own = self._random("object").standard_normal(shape) * [SPREAD_XY_M, SPREAD_XY_M, SPREAD_YAW_RAD]
        off = self._random("robot", sensor.name, robot).standard_normal(shape)
        off = off * [self.error.xy_m, self.error.xy_m, self.error.yaw_rad]
        x = positions[:, None, 0] + own[..., 0] - (sensor.x + off[..., 0])
        y = positions[:, None, 1] + own[..., 1] - (sensor.y + off[..., 1])
        cos, sin = np.cos(off[..., 2]), np.sin(off[..., 2])
        seen_x = sensor.x + cos * x + sin * y
        seen_y = sensor.y - sin * x + cos * y
        return np.stack(
            [seen_x - positions[:, None, 0], seen_y - positions[:, None, 1], own[..., 2] - off[..., 2]], axis=2
        )

    def _random(self, *use: str | int) -> np.random.Generator:
        return random_source(self.world_seed, self.object, *use)


def measured_ranges(exact: Floats, normal: Floats, lidar: LidarModel, crossing: Crossing | None) -> Floats:
    """Add the world's noise to exact ranges (N, c), inf for a no-return, and classify the beams as measured ones are.

    Args:
        exact: metres.
        normal: (N, c) standard-normal numbers.
        lidar: its range limits apply.
        crossing: distances at which the c beams cross the workspace; None: there is no workspace.
    """
    returned = np.isfinite(exact)
    near = np.where(returned, exact, 0.0)
    deviation = np.where(near > FAR_M, np.maximum(NEAR_NOISE_M, FAR_NOISE_RATIO * near), NEAR_NOISE_M)
    ranges = np.where(returned, near + deviation * normal, NO_RETURN)
    ranges = np.where(ranges < lidar.range_min, MISSING, np.where(ranges > lidar.range_max, NO_RETURN, ranges))
    if crossing is not None:
        before = np.isfinite(ranges) & crossing.before(ranges)
        ranges = np.where(np.isfinite(ranges) & ~before & ~crossing.inside(ranges), NO_RETURN, ranges)
        ranges = np.where(before, MISSING, ranges)
    return ranges


def _widened(columns: NDArray[np.intp], beams: int) -> NDArray[np.intp]:
    """Beams on which the object returns, and a few to each side; all beams where it never returns."""
    if not len(columns):
        return np.arange(beams, dtype=np.intp)
    near = (columns[:, None] + np.arange(-_MARGIN_BEAMS, _MARGIN_BEAMS + 1)) % beams
    return np.unique(near).astype(np.intp)
