"""Values of looks of a shipped object by the core: as the service computes them, and as they turn out."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.voa_assets.mugs import scenario_of
from voa_assets import path
from voa_core.assistance import Valuation
from voa_core.checks import Floats
from voa_core.estimates import Estimate
from voa_core.grasps import best_grasp
from voa_core.looks import Looks
from voa_core.ranking import Ranking, rank_looks
from voa_core.recommendation import Recommendation, recommend
from voa_core.scan_model import ScanModel
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.simulated_weights import SimulatedWeights, simulated_looks
from voa_core.simulation import Sampling, samples_per_pose
from voa_core.updating import update_estimate

NOISE_M, LOST = 0.003, 0.04
"""Range noise near by and share of lost beams of an LDS-01, which the datasheet allows to be worse."""


@dataclass(frozen=True, eq=False)
class Story:
    """A scenario with its looks over simulated scans, under the belief before the first look.

    Attributes:
        scenario: of one of the project's objects, with a spread.
    """

    scenario: Scenario

    @classmethod
    def of(cls, name: str) -> "Story":
        return cls(scenario_of(path(f"{name}/scenario.json")))

    @cached_property
    def valuation(self) -> Valuation:
        return Valuation(self.scenario.prior, self.scenario.table, self.scenario.policy, "executed")

    def looks(self, sampling: Sampling) -> Looks:
        model = ScanModel.of(self.scenario)
        of = simulated_looks(model, sampling, lists=self.scenario.lists, log_sums_of=lambda _sensor: None)
        return Looks(of)

    @cached_property
    def sampling(self) -> Sampling:
        return Sampling(self.scenario.seed, samples_per_pose(len(self.scenario.poses)))

    @cached_property
    def ranking(self) -> Ranking:
        return rank_looks(self.scenario.sensors, self.looks(self.sampling), self.valuation)

    @cached_property
    def recommendation(self) -> Recommendation:
        fresh = self.looks(self.sampling.fresh())
        return recommend(self.ranking, self.looks(self.sampling), self.valuation, fresh=fresh)

    def expected_entropies(self) -> dict[str, float]:
        """Expected Shannon entropy of the belief after a look, bits, by sensor: what a look for information lowers."""
        return {sensor.name: self._expected_entropy(sensor.name) for sensor in self.scenario.sensors}

    def _expected_entropy(self, name: str) -> float:
        weights = self.looks(self.sampling).together(self.scenario.sensor(name))
        assert isinstance(weights, SimulatedWeights)
        assert weights.matrix is not None
        after = weights.matrix * self.scenario.prior.p
        after /= after.sum(axis=1, keepdims=True)
        entropy = -(after * np.log2(np.maximum(after, 1e-300))).sum(axis=1)
        return float(self.scenario.prior.p @ entropy.reshape(len(self.scenario.poses), -1).mean(axis=1))

    def success_after(self, sensors: Sequence[str], scans_per_pose: int, seed: int) -> float:
        """Mean success of the grasp chosen after looks, over fresh noisy scans of objects that lie off their poses."""
        table, prior = self.scenario.table, self.scenario.prior
        rng = np.random.default_rng(seed)
        total = 0.0
        for pose in range(len(self.scenario.poses)):
            for _ in range(scans_per_pose):
                chosen = best_grasp(table, self._belief_after(sensors, pose, rng)).index
                assert chosen is not None
                total += prior.p[pose] * float(table.scores[chosen, pose]) / scans_per_pose
        return total

    def _belief_after(self, sensors: Sequence[str], pose: int, rng: np.random.Generator) -> Floats:
        spread = self.scenario.spread
        assert spread is not None
        off = rng.standard_normal(3) * [spread.xy_m, spread.xy_m, spread.yaw_rad]
        estimate = Estimate.of(self.scenario.prior)
        for name in sensors:
            sensor = self.scenario.sensor(name)
            exact = self.scenario.predictor.predict_displaced(sensor, off[None, None, :], first=pose).dense()[0]
            measured = exact + NOISE_M * rng.standard_normal(len(exact))
            lost = rng.random(len(exact)) < LOST
            ranges = np.where(np.isfinite(measured) & ~lost, measured, 0.0)
            scan = Scan(ranges, self.scenario.lidar.grid)
            estimate = update_estimate(estimate, self.scenario.evidence(scan, sensor), self.scenario.policy).estimate
        return estimate.belief.p
