"""The model of scans to come, against the update that runs when they have been taken."""

from dataclasses import replace

import numpy as np
import pytest

from tests.voa_core.simulated_worlds import LIDAR, NEAR, OBJECT, POSES, SCORES, SPREAD, STD
from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import rule_of
from voa_core.scan_model import ScanModel
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling
from voa_core.updating import UpdatePolicy, update_estimate
from voa_core.workspace import Workspace

SCENARIO = Scenario(
    POSES,
    GraspTable.of_probabilities(["a", "b", "c"], SCORES, 5),
    (NEAR,),
    predictor_of_mesh(OBJECT, POSES, LIDAR),
    rule_of("beam", LIDAR),
    UpdatePolicy(),
    Belief.of([0.3, 0.25, 0.2, 0.15, 0.1]),
    Workspace((-0.2, -0.2), (0.2, 0.2)),
    spread=SPREAD,
    seed="a scenario",
)
SAMPLING = Sampling(SCENARIO.seed, 2)


def scan_of_row(look: SimulatedWeights, row: int) -> Scan:
    scans = look.scans[0]
    ranges: Floats = np.full(LIDAR.grid.beams, np.inf)
    ranges[scans.columns] = scans.ranges[row]
    return Scan(ranges, LIDAR.grid)


@pytest.mark.parametrize("listed", [True, False])
def test_weights_are_those_of_the_update_that_will_run(listed: bool) -> None:
    sensor = NEAR if listed else replace(NEAR, name="here")
    model = ScanModel.of(SCENARIO, STD)
    look = SimulatedWeights.of(model, sensor, SAMPLING, listed=listed)
    every = np.arange(len(look.scans[0].ranges))
    beliefs = look.beliefs(every, [SCENARIO.prior] * len(every), SCENARIO.policy)
    estimate = SCENARIO.start
    for row in every:
        done = update_estimate(estimate, SCENARIO.evidence(scan_of_row(look, int(row)), sensor, STD), SCENARIO.policy)
        assert done.accepted
        np.testing.assert_allclose(beliefs[row].p, done.belief.p, rtol=0, atol=1e-12)
    # A look from there has been taken: the next one is weighed together with it.
    first = SCENARIO.evidence(scan_of_row(look, 3), sensor, STD)
    estimate = update_estimate(estimate, first, SCENARIO.policy).estimate
    again = SimulatedWeights.of(model, sensor, SAMPLING, listed=listed, log_sums=estimate.places[0].log_sums)
    beliefs = again.beliefs(every, [estimate.belief] * len(every), SCENARIO.policy)
    for row in every:
        evidence = SCENARIO.evidence(scan_of_row(again, int(row)), sensor, STD)
        done = update_estimate(estimate, evidence, SCENARIO.policy, number=1)
        np.testing.assert_allclose(beliefs[row].p, done.belief.p, rtol=0, atol=1e-12)
