"""Loading of the kernels of a scan update, so that the first scan of a process is no slower than the tenth.

The first call of any kernel initialises numba, which takes longer than hundreds of updates; each kernel is then read
from the disk at its own first call. Kernels of rankings and of simulated looks are left to their first use.
"""

import numpy as np

from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh
from voa_core.rules.registry import RULES, rule_of
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.updating import UpdatePolicy


def load_kernels() -> None:
    """Predict a scan of a tetrahedron at two poses, and compare it under every update rule."""
    corners = 0.1 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    tetrahedron = Object.from_arrays(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    poses = PoseSet.from_arrays(["A", "B"], np.zeros((2, 3)), [[1, 0, 0, 0], [0, 0, 0, 1]])
    lidar = LidarModel(BeamGrid(90, 0.0, np.pi / 45), 0.1, 2.0, 0.02, "missing", 0.01, 0.02, 0.05)
    sensor = SensorConfiguration("a", -0.3, 0.03, 0.0)
    predictor = predictor_of_mesh(tetrahedron, poses, lidar)
    scan = Scan(predictor.predict(sensor).dense()[0], lidar.grid)
    table = GraspTable.of_probabilities(["g"], [[0.5, 0.6]], 2)
    for name in RULES:
        rule = rule_of(name, lidar)
        scenario = Scenario(poses, table, (sensor,), predictor, rule, UpdatePolicy(), Belief.uniform(2))
        mistakes_of_scan(scenario, scan, sensor, None, scenario.evidence(scan, sensor))
