"""Trials of an evaluation: drops of an object, the scans that are taken of it, and the grasps that are attempted.

A trial, its scans and its attempts depend on the seed and on names alone. So every policy, update rule and level of a
disturbance has the same drops, and what they share cancels in a difference.
"""

import math
import zlib
from dataclasses import dataclass, field, replace

import numpy as np

from voa_evaluation.looks.setting import Belief
from voa_fleet.episodes.bench import Bench, make_bench
from voa_fleet.world.attempts import Result, attempt_grasp
from voa_fleet.world.imperfections import Clutter, Imperfections
from voa_fleet.world.object_poses import Drop, make_drop
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.sessions import Scan

HINT = 0.5
"""Concentration of the Dirichlet distribution of hinted beliefs: below 1, so that a few poses have most of it."""
_BOX_M = 0.04
_NEAR_M, _FAR_M = 0.13, 0.25


@dataclass(frozen=True)
class Trial:
    """A drop with the belief before any look, and the random choices of the policies.

    Attributes:
        object: name of the object.
        kind: of the belief.
        drop: its index counts within object and kind of belief.
        belief: before any look, (poses,); the true pose is drawn from it.
        bearing_rad: direction from which the sensor robot comes.
        random_look: index of a sensor configuration, each as likely.
    """

    object: str
    kind: Belief
    drop: Drop
    belief: tuple[float, ...]
    bearing_rad: float
    random_look: int


def random_source(seed: int, *names: str | int) -> np.random.Generator:
    """Make a random generator that depends on a seed and on names and numbers, in order."""
    return np.random.default_rng(
        [seed, *(part if isinstance(part, int) else zlib.crc32(part.encode()) for part in names)]
    )


def make_trial(target: FleetObject, kind: Belief, index: int, imperfections: Imperfections, seed: int) -> Trial:
    """Draw a trial.

    Args:
        target: the object.
        kind: of the belief.
        index: of the drop within object and kind of belief.
        imperfections: noise of the object's place.
        seed: of all trials.
    """
    rng = random_source(seed, "drop", target.name, kind, index)
    count = len(target.poses)
    belief = np.full(count, 1.0 / count) if kind == "uniform" else rng.dirichlet(np.full(count, HINT))
    drop = make_drop(target, index, belief.tolist(), imperfections, rng)
    return Trial(
        object=target.name,
        kind=kind,
        drop=drop,
        belief=tuple(float(share) for share in belief),
        bearing_rad=float(rng.uniform(0.0, 2.0 * math.pi)),
        random_look=int(rng.integers(len(target.scenario.sensors))),
    )


def boxes(trial: Trial, count: int, seed: int) -> tuple[Clutter, ...]:
    """Draw boxes of 4 x 4 cm that stand 13 to 25 cm from the middle of the table.

    The boxes of a larger count begin with those of a smaller one.
    """
    rng = random_source(seed, "clutter", trial.object, trial.kind, trial.drop.index)
    clutter = []
    for index in range(count):
        distance, bearing, yaw = rng.uniform([_NEAR_M, 0.0, 0.0], [_FAR_M, 2.0 * math.pi, math.pi])
        centre = distance * math.cos(bearing), distance * math.sin(bearing)
        clutter.append(Clutter(f"box{index}", centre, (_BOX_M, _BOX_M, 0.2), yaw))
    return tuple(clutter)


@dataclass(eq=False)
class TrialBench:
    """The bench of one object: takes scans, attempts grasps and keeps the results.

    Attributes:
        target: the object.
        seed: of the errors of scans.
    """

    target: FleetObject
    seed: int
    _benches: dict[tuple[Clutter, ...], Bench] = field(default_factory=dict)
    _results: dict[tuple[str, int, str], Result] = field(default_factory=dict)

    def scan(self, trial: Trial, sensor: SensorConfiguration, imperfections: Imperfections) -> Scan:
        """Take a scan of one revolution with the robot's and the lidar's errors.

        The random numbers do not depend on the imperfections: two levels of a disturbance differ in it alone.

        Args:
            trial: in which the object lies.
            sensor: sensor configuration at which the robot believes to be.
            imperfections: sizes of the errors, and the clutter.
        """
        rng = random_source(self.seed, "scan", trial.object, trial.kind, trial.drop.index, sensor.name)
        robot = self._bench(imperfections.clutter).place(trial.drop, rng, imperfections).robot
        robot.stand_at(sensor)
        return robot.take_scan()

    def attempt(self, trial: Trial, grasp: str) -> Result:
        """Attempt a grasp where the object lies; each pair of trial and grasp is simulated once.

        Raises:
            UnstableSimulation: the simulation became unstable.
        """
        key = trial.kind, trial.drop.index, grasp
        if key not in self._results:
            bench = self._bench(())
            self._results[key] = attempt_grasp(bench.scene.world, bench.arm.plan(grasp), trial.drop.place).result
        return self._results[key]

    @property
    def attempts(self) -> int:
        """Number of attempts that were simulated."""
        return len(self._results)

    def _bench(self, clutter: tuple[Clutter, ...]) -> Bench:
        if clutter in self._benches:
            return self._benches[clutter]
        bench = make_bench(self.target, replace(Imperfections(), clutter=clutter), self.seed)
        if not any(box.name.startswith("box") for box in clutter):  # boxes are those of one trial: not worth keeping
            self._benches[clutter] = bench
        return bench
