import math

import numpy as np
import pytest

from voa_fleet.world.objects import OBJECTS, named_object
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.scenarios import MeasuredScores, Pose
from voa_setup.grasps.scoring import geometric_scores

YAW_RAD = math.radians(3.0)


def shipped(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Geometric and simulated scores of a shipped object's grasps, (grasps, poses)."""
    target = named_object(name)
    grasps = [target.grasp(grasp) for grasp in target.grasps]
    scores = geometric_scores(
        target.mesh, target.scenario.poses, grasps, target.physics.gripper, xy_m=0.005, yaw_rad=YAW_RAD
    )
    measured = target.scenario.scores
    assert isinstance(measured, MeasuredScores)
    return np.array(scores), np.array(measured.successes) / measured.attempts


def test_geometry_agrees_with_simulated_attempts_on_the_shipped_objects() -> None:
    """All 132 cells lay on the same side of 0.5, with a correlation of 0.99, when this was written."""
    pairs = [shipped(name) for name in OBJECTS]
    geometric, simulated = (np.concatenate([pair[side].ravel() for pair in pairs]) for side in (0, 1))
    assert ((geometric > 0.5) == (simulated > 0.5)).mean() >= 0.95
    assert np.corrcoef(geometric, simulated)[0, 1] >= 0.97
    assert np.abs(geometric - simulated).mean() <= 0.04


def test_more_noise_lowers_a_score_and_the_same_seed_repeats_it() -> None:
    target = named_object("block")
    grasp = target.grasp("TD0")

    def score(xy_m: float, seed: int = 0) -> float:
        args = target.mesh, target.scenario.poses[:1], [grasp], target.physics.gripper
        return geometric_scores(*args, xy_m=xy_m, yaw_rad=YAW_RAD, seed=seed)[0][0]

    assert score(0.0) > 0.95
    assert 0.2 < score(0.01) < score(0.005) < 1.0
    assert score(0.01) == score(0.01)


def test_a_hand_in_the_table_scores_nothing() -> None:
    target = named_object("mallet")
    grasps = [
        GraspGeometry(tool_centre_point=(0.08, 0.0, height), approach=(0.0, 0.0, -1.0), closing=(0.0, 1.0, 0.0))
        for height in (0.008, -0.001)
    ]
    scores = geometric_scores(
        target.mesh, target.scenario.poses[:1], grasps, target.physics.gripper, xy_m=0.0, yaw_rad=0.0, samples=4
    )
    assert scores == [[1.0], [0.0]]


def test_poses_without_a_position_are_refused() -> None:
    target = named_object("block")
    with pytest.raises(ValueError, match="expected position and quaternion_wxyz of pose 'U'"):
        geometric_scores(target.mesh, [Pose(name="U")], [], target.physics.gripper, xy_m=0.0, yaw_rad=0.0)
