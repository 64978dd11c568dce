"""Bench of one object, update rule and robot error: the weights of all looks, promised and really taken."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from voa_core.assistance import Valuation
from voa_core.choices import LookWeights
from voa_core.filtering import Belief
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.looks import LookOf, Looks, exact_looks
from voa_core.scan_model import ScanModel
from voa_core.scenario import Scenario
from voa_core.simulation import Sampling, samples_per_pose
from voa_core.weights import Weigher
from voa_evaluation.values.kept_weights import KeptWeights
from voa_evaluation.values.scans import WorldScans
from voa_evaluation.values.setting import RobotError
from voa_evaluation.values.world import scenario_of
from voa_fleet.world.objects import FleetObject


@dataclass(frozen=True, eq=False)
class Bench:
    """Weights of the looks at one object under one update rule, for a robot of one error.

    Attributes:
        object: name of the object.
        rule: name of the update rule.
        error: of the robot, which states it.
        scenario: of the object.
        model: of the scans that the service simulates.
        world: of the scans that are taken.
        simulated, fresh: looks over simulated scans, as the service ranks and as it evaluates the first look again.
        exact: looks over one exact scan per pose.
        taken: looks over the world's scans.
        weigher: gives the weights between exact scans.
    """

    object: str
    rule: str
    error: RobotError
    scenario: Scenario
    model: ScanModel
    world: WorldScans
    simulated: Looks
    fresh: Looks
    exact: Looks
    taken: Looks
    weigher: Callable[[SensorConfiguration], Weigher]

    @property
    def sensors(self) -> tuple[SensorConfiguration, ...]:
        """Places from which the robot can look."""
        return self.scenario.sensors

    def valuation(self, belief: Belief) -> Valuation:
        """Executed valuation under a belief, as rankings over simulated scans have it."""
        return Valuation(belief, self.scenario.table, self.scenario.policy, "executed")

    def exact_valuation(self, belief: Belief) -> Valuation:
        """Posterior valuation under a belief, the paper's, as rankings over exact scans have it."""
        return Valuation(belief, self.scenario.table, self.scenario.policy, "posterior")

    def taken_by(self, robots: tuple[int, ...], samples: int) -> Looks:
        """Looks over the world's scans in which several looks in a row are taken by these robots."""
        return Looks(_kept_looks(replace(self.world, robots=robots), Sampling(self.object, samples)))


def make_bench(target: FleetObject, rule: str, error: RobotError, scans: int, seed: int) -> Bench:
    """Make the bench of an object.

    Args:
        target: the object.
        rule: name of the update rule.
        error: of the robot, which states it.
        scans: number of the world's scans of each pose at each place.
        seed: of the world's errors.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    scenario = scenario_of(target, rule)
    std = SensorUncertainty(error.xy_m, error.yaw_rad) if error.xy_m > 0.0 or error.yaw_rad > 0.0 else None
    model = ScanModel.of(scenario, std)
    world = WorldScans(**vars(model), object=target.name, world_seed=seed, error=error)
    sampling = Sampling(scenario.seed, samples_per_pose(len(scenario.poses)))
    weigher = _kept_weigher(scenario)
    return Bench(
        object=target.name,
        rule=rule,
        error=error,
        scenario=scenario,
        model=model,
        world=world,
        simulated=Looks(_kept_looks(model, sampling)),
        fresh=Looks(_kept_looks(model, sampling.fresh())),
        exact=Looks(exact_looks(weigher)),
        taken=Looks(_kept_looks(world, Sampling(target.name, scans))),
        weigher=weigher,
    )


def _kept_looks(model: ScanModel, sampling: Sampling) -> LookOf:
    """Make a function that weighs the scans in a row from a place once and keeps the weights."""
    kept: dict[tuple[str, int], LookWeights] = {}
    uniform = Belief.uniform(len(model.poses))

    def of(sensor: SensorConfiguration, scans: int) -> LookWeights:
        key = sensor.name, scans
        if key not in kept:
            weights = KeptWeights.of(model, sensor, sampling, np.float64, listed=True, looks=scans)
            kept[key] = weights.seen_with(uniform, model.policy)
        return kept[key]

    return of


def _kept_weigher(scenario: Scenario) -> Callable[[SensorConfiguration], Weigher]:
    kept: dict[str, Weigher] = {}

    def of(sensor: SensorConfiguration) -> Weigher:
        if sensor.name not in kept:
            kept[sensor.name] = scenario.weigher(sensor, np.float64, keep=True)
        return kept[sensor.name]

    return of
