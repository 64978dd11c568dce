import math

import numpy as np
import pytest

from tests.support.shapes import EVERYDAY, box
from voa_fleet.world.objects import GripperSetting, named_object
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.scenarios import Pose
from voa_setup.grasps.proposals import NoGrasp, ProposedGrasp, propose_grasps
from voa_setup.grasps.scoring import geometric_scores
from voa_setup.grippers import GRIPPERS

YAW_RAD = math.radians(3.0)
UPRIGHT = [
    Pose(name="upright 0", position=[0.0, 0.0, 0.0], quaternion_wxyz=[1.0, 0.0, 0.0, 0.0]),
    Pose(name="upright 90", position=[0.0, 0.0, 0.0], quaternion_wxyz=[math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]),
]


def kind_on_the_mug(grasp: GraspGeometry) -> str:
    """Kind of a grasp of the shipped mug, as the paper calls them; the wall is at 38 mm, the handle beyond 44 mm."""
    x, y, _ = grasp.tool_centre_point
    distance = math.hypot(x, y)
    inward = -(grasp.approach[0] * x + grasp.approach[1] * y) / max(distance, 1e-9)
    radial = abs(grasp.closing[0] * x + grasp.closing[1] * y) / max(distance, 1e-9)
    assert grasp.width_m is not None
    thin = grasp.width_m < 0.012
    if grasp.approach[2] < -0.99 and thin:
        return "rim from above" if distance < 0.044 and radial > 0.8 else "handle from above"
    return "handle from outside in" if thin and inward > 0.9 and distance > 0.044 else "other"


@pytest.mark.parametrize("opening_m", [0.018, 0.085])
def test_the_paper_s_kinds_of_grasp_are_proposed_for_the_mug(opening_m: float) -> None:
    mug = named_object("mug").with_opening(opening_m)
    poses = mug.scenario.poses
    proposals = propose_grasps(mug.mesh, poses, [1.0 / len(poses)] * len(poses), mug.physics.gripper)
    kinds = {kind_on_the_mug(grasp.geometry) for grasp in proposals}
    assert kinds >= {"rim from above", "handle from outside in", "handle from above"}
    assert len(proposals) == 12
    assert len({grasp.name for grasp in proposals}) == 12
    scores = np.array(scores_of(proposals, mug.physics.gripper, poses))
    assert scores.max(axis=0).min() > 0.4, "every pose has a grasp"


def scores_of(proposals: list[ProposedGrasp], gripper: GripperSetting, poses: list[Pose]) -> list[list[float]]:
    mesh = named_object("mug").mesh
    grasps = [grasp.geometry for grasp in proposals]
    return geometric_scores(mesh, poses, grasps, gripper, xy_m=0.005, yaw_rad=YAW_RAD)


@pytest.mark.parametrize("name", EVERYDAY)
def test_everyday_shapes_have_a_grasp_at_every_pose(name: str) -> None:
    mesh, gripper = EVERYDAY[name](), GRIPPERS["2f-85"]
    proposals = propose_grasps(mesh, UPRIGHT, [0.5, 0.5], gripper, count=3)
    grasps = [grasp.geometry for grasp in proposals]
    scores = geometric_scores(mesh, UPRIGHT, grasps, gripper, xy_m=0.005, yaw_rad=YAW_RAD)
    assert np.array(scores).max(axis=0).min() > 0.5
    if name == "bowl":
        assert any((grasp.width_m or 1.0) < 0.03 for grasp in grasps), "by its rim"


def test_equal_seeds_give_equal_proposals() -> None:
    first, second = (propose_grasps(box(), UPRIGHT[:1], [1.0], GRIPPERS["2f-85"], count=2, seed=3) for _ in range(2))
    assert first == second


def test_an_object_that_is_too_wide_is_refused_in_words() -> None:
    gripper = GripperSetting(opening_m=0.03, force_n=40.0)
    with pytest.raises(NoGrasp, match=r"can hold the object at no pose: it needs .* 1\.5 to 27 mm wide"):
        propose_grasps(box(), UPRIGHT, [0.5, 0.5], gripper)


def test_poses_and_prior_must_match() -> None:
    with pytest.raises(ValueError, match="expected one share of the prior per pose, got 2 poses and 1 shares"):
        propose_grasps(box(), UPRIGHT, [1.0], GRIPPERS["2f-85"])


def test_an_object_beyond_the_arm_has_a_message_of_its_own() -> None:
    far = [Pose(name="far", position=[5.0, 0.0, 0.0], quaternion_wxyz=[1.0, 0.0, 0.0, 0.0])]
    with pytest.raises(NoGrasp, match=r"could hold the object, but the simulated arm, .* does not reach it"):
        propose_grasps(box(), far, [1.0], GRIPPERS["2f-85"])
