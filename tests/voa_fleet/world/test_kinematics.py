"""The arm finds its way along straight lines, always the same way, and says when there is none."""

import mujoco
import numpy as np
import pytest

from voa_fleet.world.frames import Floats, tool_rotation
from voa_fleet.world.kinematics import APPROACH_M, LIFT_M, GraspPlan, commands, is_reachable, joint_move, plan_grasp
from voa_fleet.world.object_poses import ObjectPose
from voa_fleet.world.objects import OBJECTS, FleetObject
from voa_fleet.world.scene import World, build_world
from voa_msgs.grasp_geometry import GraspGeometry


def tools(world: World, joints: Floats) -> tuple[Floats, Floats]:
    """Places (k, 3) and rotations (k, 3, 3) of the tool."""
    data = mujoco.MjData(world.model)
    places, rotations = [], []
    for row in joints:
        data.qpos[world.joints] = row
        mujoco.mj_kinematics(world.model, data)
        places.append(data.site_xpos[world.tool].copy())
        rotations.append(data.site_xmat[world.tool].reshape(3, 3).copy())
    return np.array(places), np.array(rotations)


@pytest.mark.parametrize("grasp", ["TD0", "TD90", "OI90", "TDH0"])
def test_the_tool_comes_straight_and_goes_straight_up(
    mug: FleetObject, mug_world: World, mug_plans: dict[str, GraspPlan], grasp: str
) -> None:
    geometry, plan = mug.grasp(grasp), mug_plans[grasp]
    tip, forward = np.array(geometry.tool_centre_point), np.array(geometry.approach, dtype=float)
    places, rotations = tools(mug_world, plan.approach)
    np.testing.assert_allclose(places[-1], tip, rtol=0.0, atol=2e-4)
    along = (places - tip) @ forward
    assert -APPROACH_M - 1e-3 < along[0] < -0.95 * APPROACH_M
    assert (np.diff(along) > -2e-4).all()
    assert np.abs(places - tip - along[:, None] * forward).max() < 2e-4
    wanted = tool_rotation(geometry.approach, geometry.closing)
    for rotation in rotations:
        assert rotation[:, 2] @ wanted[:, 2] > 1.0 - 1e-5
        assert abs(rotation[:, 0] @ wanted[:, 0]) > 1.0 - 1e-5  # either way round: the gripper is symmetric
    lifted, _ = tools(mug_world, plan.lift)
    np.testing.assert_allclose(lifted[-1], tip + np.array([0.0, 0.0, LIFT_M]), rtol=0.0, atol=2e-4)


@pytest.mark.parametrize("grasp", ["TD0", "TD90", "OI90", "TDH0"])
def test_the_tool_descends_straight_to_where_its_approach_begins(
    mug_world: World, mug_plans: dict[str, GraspPlan], grasp: str
) -> None:
    plan = mug_plans[grasp]
    places, rotations = tools(mug_world, plan.descent)
    assert places[0, 2] > 0.35
    assert (np.diff(places[:, 2]) < 2e-4).all()
    assert np.abs(places[:, :2] - places[-1, :2]).max() < 2e-4
    assert np.abs(rotations - rotations[-1]).max() < 3e-3
    assert np.abs(np.diff(plan.descent, axis=0)).max() < 0.1
    assert np.abs(plan.descent[-1] - plan.approach[0]).max() < 0.01


@pytest.mark.parametrize("name", OBJECTS)
def test_every_grasp_of_every_object_is_within_reach(targets: dict[str, FleetObject], name: str) -> None:
    world = build_world(targets[name])
    for grasp in targets[name].grasps:
        assert plan_grasp(world, targets[name].grasp(grasp)) is not None
        assert is_reachable(world, targets[name].grasp(grasp))


def test_joints_never_jump(mug_plans: dict[str, GraspPlan]) -> None:
    for plan in mug_plans.values():
        rows = np.vstack([plan.approach, plan.lift])
        assert np.abs(np.diff(rows, axis=0)).max() < 0.1


def test_the_same_grasp_gives_the_same_plan(
    mug: FleetObject, mug_world: World, mug_plans: dict[str, GraspPlan]
) -> None:
    again = plan_grasp(mug_world, mug.grasp("TD0"))
    assert again is not None
    assert (again.approach == mug_plans["TD0"].approach).all()
    assert (again.lift == mug_plans["TD0"].lift).all()


@pytest.mark.parametrize("tip", [(1.2, 0.0, 0.1), (0.0, 0.0, 1.5)])
def test_a_grasp_out_of_reach_has_no_plan(mug_world: World, tip: tuple[float, float, float]) -> None:
    geometry = GraspGeometry(tool_centre_point=tip, approach=(0.0, 0.0, -1.0), closing=(1.0, 0.0, 0.0))
    assert plan_grasp(mug_world, geometry) is None
    assert not is_reachable(mug_world, geometry)


def test_the_servos_follow_within_two_millimetres(mug_world: World, mug_plans: dict[str, GraspPlan]) -> None:
    plan = mug_plans["TD0"]
    data = mujoco.MjData(mug_world.model)
    mug_world.put_object(data, ObjectPose((0.18, 0.18, 0.0), (1.0, 0.0, 0.0, 0.0)))
    data.qpos[mug_world.joints] = plan.approach[0]
    wanted, _ = tools(mug_world, plan.approach)
    worst = 0.0
    for row, place in zip(commands(plan.approach), wanted, strict=True):
        data.ctrl[mug_world.servos] = row
        mug_world.step(data, 5)
        worst = max(worst, float(np.linalg.norm(data.site_xpos[mug_world.tool] - place)))
    assert worst < 0.002


def test_a_joint_move_starts_and_ends_gently_where_it_should() -> None:
    start, end = np.zeros(6), np.array([0.5, -1.0, 0.0, 0.2, 0.0, 0.0])
    rows = joint_move(start, end, speed_rad_s=1.0)
    assert len(rows) == 100
    np.testing.assert_allclose(rows[-1], end, rtol=0.0, atol=1e-12)
    assert np.abs(rows[0]).max() < 1e-4
    assert np.abs(np.diff(rows, axis=0)).max() < 0.02
