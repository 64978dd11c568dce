import math

import numpy as np

from tests.support.standing_robots import facing
from tests.voa_setup.calibration.calibrations import bracket, scene_of
from voa_setup.calibration.planar import planar
from voa_setup.calibration.proposals import clusters, lidar_poses, proposals
from voa_setup.calibration.stops import Measured


def test_the_cluster_of_the_object_is_proposed_and_the_walls_are_not() -> None:
    bench = bracket()
    target = scene_of(bench).at("as made", None)
    lidar = facing(0.8, 0.4, 2.5)
    measured = Measured(target, scene_of(bench).grid, bench.ranges(lidar, "as made"))
    [(direction, nearest)] = clusters(measured)
    assert abs(math.remainder(direction + 2.5, math.tau)) < 0.3
    assert 0.2 < nearest < 0.45
    poses = lidar_poses(proposals(measured), target.centre)
    assert np.linalg.norm((poses - planar(lidar))[:, :2], axis=1).min() < 0.05


def test_a_scan_in_which_nothing_returns_proposes_nothing() -> None:
    target = scene_of(bracket()).at("as made", None)
    for value in (math.inf, math.nan, 2.0):
        measured = Measured(target, scene_of(bracket()).grid, np.full(360, value))
        assert len(proposals(measured)) == 0
