"""Compile every kernel for the types that the service uses: `python -m voa_core.warmup`.

The compiled code is written beside the sources, or to NUMBA_CACHE_DIR.
"""

import numpy as np

from voa_core.displacements import Spread
from voa_core.evidence import evidence_of_scan
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.mistakes.effort import THOROUGH
from voa_core.mistakes.heights import Mesh
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.mistakes.scenarios import mistakes_of_scenario
from voa_core.mistakes.surface import Surface
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, predictor_of_mesh
from voa_core.ranking import rank
from voa_core.rules.registry import RULES, rule_of
from voa_core.scan_model import ScanModel
from voa_core.scans import NO_RETURN, Scan
from voa_core.scenario import Scenario
from voa_core.simulated_weights import SimulatedWeights
from voa_core.simulation import Sampling
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher
from voa_core.workspace import Workspace


def warm_up() -> None:
    """Run every kernel once for each type of its arguments, on a tetrahedron at two poses.

    Where compiled kernels are sealed in an image, a call with other types is an error: a test compares the types that
    are compiled here with those that the service uses.
    """
    corners = 0.1 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    object_ = Object.from_arrays(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    poses = PoseSet.from_arrays(["A", "B"], np.zeros((2, 3)), [[1, 0, 0, 0], [0, 0, 0, 1]])
    lidar = LidarModel(BeamGrid(90, 0.0, np.pi / 45), 0.1, 2.0, 0.02, "missing", 0.01, 0.02, 0.05)
    sensor = SensorConfiguration("a", -0.3, 0.03, 0.0)
    predictor = predictor_of_mesh(object_, poses, lidar)
    prediction = predictor.predict(sensor)
    predictor.predict(SensorConfiguration("inside", 0.02, 0.02, 0.0))
    scan = Scan(prediction.dense()[0], lidar.grid)
    table = GraspTable.of_successes(["g"], [[5, 6]], 10, 2)
    Surface(object_).holds(corners, 1e-4)
    possible = np.ones(len(poses), dtype=bool)
    sampling, spread = Sampling("warm-up", 1), Spread(0.005, 0.05)
    workspace = Workspace((-0.2, -0.2), (0.2, 0.2))
    for name in RULES:
        rule = rule_of(name, lidar)
        scenario = Scenario(poses, table, (sensor,), predictor, rule, UpdatePolicy(), Belief.uniform(2), workspace)
        mistakes_of_scenario(scenario, Mesh(object_), THOROUGH)
        for uncertainty in (None, SensorUncertainty(0.01, 0.02)):
            evidence = scenario.evidence(scan, sensor, uncertainty)
            evidence.sight.misses_object(possible)
            mistakes_of_scan(scenario, scan, sensor, uncertainty, evidence)
        model = ScanModel(predictor, rule, UpdatePolicy(), "warm-up", spread=spread)
        simulated = SimulatedWeights.of(model, sensor, sampling)
        earlier = np.zeros((len(poses), simulated.copies.per_pose))
        SimulatedWeights.of(model, sensor, sampling, looks=2, log_sums=earlier)
        evidence_of_scan(scan, sensor, predictor, rule).sight.misses_object(possible)
        for dtype in (np.float32, np.float64):
            rule.statistic_among(prediction.ranges.astype(dtype))  # as a rule of another package may
            for keep in (False, True):
                weigher = Weigher.of(rule, prediction, dtype, keep=keep)
                weigher.weights(np.arange(2), np.arange(2))
                for belief in (Belief.uniform(2), Belief.of([1.0, 0.0])):  # all weights, and those of some poses
                    rank([sensor], {sensor: weigher}.__getitem__, belief, table, UpdatePolicy())


def load_scan_kernels() -> None:
    """Load what the first scan of a process needs: numba's compiler, and the kernels that weigh a scan.

    Kernels that are not on the disk yet are compiled.
    """
    lidar = LidarModel(BeamGrid(4, 0.0, 1.0), 0.1, 2.0, 0.02, "missing", 0.01, 0.02, 0.05)
    sensor, ranges = SensorConfiguration("a", 0.0, 0.0, 0.0), np.array([[0.5, 0.5, 0.6, NO_RETURN]])
    predictor = ObservationPredictor(PoseSet.named(["A"]), lidar, {"a": ranges})
    for name in RULES:
        rule = rule_of(name, lidar)
        evidence = evidence_of_scan(Scan(ranges[0], lidar.grid), sensor, predictor, rule, listed=True)
        evidence.sight.misses_object(np.array([True]))


if __name__ == "__main__":
    warm_up()
