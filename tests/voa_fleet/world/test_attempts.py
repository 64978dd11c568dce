"""Without noise every grasp does what it should, and every failure has its reason."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.fleet_objects import with_pieces
from voa_fleet.world.attempts import attempt_grasp, attempt_rng
from voa_fleet.world.frames import angle_between, matrix_of
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.object_poses import ObjectPose, noisy_pose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World, build_world
from voa_msgs.grasp_geometry import GraspGeometry

LETTERS = {
    "L": "lifted",
    "s": "stopped on approach",
    "n": "nothing between the fingers",
}
"""L succeeds. s: the hand meets something first. n: nothing is where the fingers close, or it was pushed away."""

TABLES = {
    # The support of the paper's Fig. 2. TD0 at U_0 and TD90 at U_90 stop on the handle, both at D_90 on the base.
    "mug": {
        "U_0": "s L n L",
        "U_90": "L s L n",
        "D_90": "s s L n",
        "U_180": "L L n n",
        "U_45": "L L n n",
        "U_135": "L L n n",
    },
    # TDH reaches the handle where it lies, and at E, 25 mm higher, as well; END stops on the handle that points up.
    "mallet": {
        "F_0": "L n n n n n",
        "F_90": "n L n n n n",
        "F_180": "n n L n n n",
        "F_270": "n n n L n n",
        "S_0": "n n n n L s",
        "S_90": "n n n n L s",
        "E_0": "L n n n n L",
        "E_90": "n L n n n L",
    },
    # TD stops on the block's top unless the recess is there; OI pushes the block away unless it is.
    "block": {
        "U_0": "L s s s n n",
        "U_90": "s L s s L n",
        "U_180": "s s L s n n",
        "U_270": "s s s L n L",
        "D_90": "s s s s L n",
        "D_270": "s s s s n L",
    },
}


def results_without_noise(target: FleetObject) -> dict[str, list[str]]:
    world = build_world(target)
    plans = {grasp: plan_grasp(world, target.grasp(grasp)) for grasp in target.grasps}
    return {
        pose: [attempt_grasp(world, plans[grasp], scenario_pose(target, pose)).result for grasp in target.grasps]
        for pose in target.poses
    }


@pytest.mark.parametrize("name", list(TABLES))
def test_without_noise_grasps_succeed_and_fail_as_they_should(targets: dict[str, FleetObject], name: str) -> None:
    expected = {pose: [LETTERS[letter] for letter in row.split()] for pose, row in TABLES[name].items()}
    assert results_without_noise(targets[name]) == expected


@pytest.mark.parametrize("name", ["mug", "block"])
def test_convex_pieces_of_the_mesh_give_the_results_of_solids_made_by_hand(
    targets: dict[str, FleetObject], name: str
) -> None:
    expected = {pose: [LETTERS[letter] for letter in row.split()] for pose, row in TABLES[name].items()}
    assert results_without_noise(with_pieces(targets[name])) == expected


def test_an_attempt_is_measured(mug: FleetObject, mug_world: World, mug_plans: dict[str, GraspPlan]) -> None:
    lifted = attempt_grasp(mug_world, mug_plans["TD0"], scenario_pose(mug, "U_180"))
    assert lifted.success
    assert lifted.rise_m == pytest.approx(0.15, abs=0.002)
    assert lifted.tool_error_m < 0.002
    assert lifted.gap_m == pytest.approx(0.004, abs=0.002)  # the wall of the mug
    stopped = attempt_grasp(mug_world, mug_plans["TD0"], scenario_pose(mug, "D_90"))
    assert not stopped.success
    assert stopped.tool_error_m > 0.01


def test_an_attempt_does_not_depend_on_the_one_before(
    mug: FleetObject, mug_world: World, mug_plans: dict[str, GraspPlan]
) -> None:
    pose = noisy_pose(scenario_pose(mug, "U_45"), Imperfections(object_xy_m=0.005), attempt_rng(3, "U_45", "TD0", 0))
    first = attempt_grasp(mug_world, mug_plans["TD0"], pose)
    attempt_grasp(mug_world, mug_plans["OI90"], scenario_pose(mug, "U_90"))
    assert attempt_grasp(mug_world, mug_plans["TD0"], pose) == first
    assert attempt_grasp(build_world(mug), mug_plans["TD0"], pose) == first


def test_a_grasp_out_of_reach_says_so(mug: FleetObject, mug_world: World) -> None:
    assert attempt_grasp(mug_world, None, scenario_pose(mug, "U_0")).result == "out of reach"


def test_an_object_where_the_approach_begins_is_in_the_way(
    mug: FleetObject, mug_world: World, mug_plans: dict[str, GraspPlan]
) -> None:
    floating = ObjectPose((0.0, 0.0, 0.12), (1.0, 0.0, 0.0, 0.0))
    assert attempt_grasp(mug_world, mug_plans["TD0"], floating).result == "in the way"


def test_a_slippery_mug_slips(mug: FleetObject) -> None:
    physics = mug.physics.model_copy(update={"friction": 0.01})
    oily = replace(mug, physics=physics)
    world = build_world(oily)
    for geom in ("finger_right", "finger_left"):
        world.model.geom(geom).friction[0] = 0.01
    plan = plan_grasp(world, mug.grasp("TD0"))
    assert attempt_grasp(world, plan, scenario_pose(mug, "U_180")).result == "slipped"


def test_fingers_that_close_on_top_of_a_handle_do_not_hold_it(targets: dict[str, FleetObject]) -> None:
    mallet = targets["mallet"]
    world = build_world(mallet)
    high = GraspGeometry(tool_centre_point=(0.08, 0.0, 0.026), approach=(0.0, 0.0, -1.0), closing=(0.0, 1.0, 0.0))
    attempt = attempt_grasp(world, plan_grasp(world, high), scenario_pose(mallet, "F_0"))
    assert attempt.result == "not held"
    assert attempt.rise_m < 0.01


def test_noise_moves_the_object_in_the_plane_and_turns_it_about_the_vertical(mug: FleetObject) -> None:
    imperfections = Imperfections(object_xy_m=0.01, object_yaw_rad=0.1)
    exact = scenario_pose(mug, "D_90")
    noisy = [noisy_pose(exact, imperfections, attempt_rng(0, "D_90", "TD0", index)) for index in range(2000)]
    moved = np.array([pose.position for pose in noisy]) - exact.position
    assert moved[:, :2].std(axis=0) == pytest.approx([0.01, 0.01], rel=0.06)
    assert np.abs(moved[:, 2]).max() == 0.0
    ups = [matrix_of(pose.quaternion_wxyz)[2] for pose in noisy]
    assert max(angle_between(up, matrix_of(exact.quaternion_wxyz)[2]) for up in ups) < 1e-7
    turns = [
        angle_between(matrix_of(pose.quaternion_wxyz)[:, 0], matrix_of(exact.quaternion_wxyz)[:, 0]) for pose in noisy
    ]
    assert np.sqrt(np.mean(np.square(turns))) == pytest.approx(0.1, rel=0.06)


def test_noise_depends_on_seed_pose_grasp_and_attempt_alone() -> None:
    draws = {
        key: attempt_rng(*key).standard_normal()
        for key in [(0, "U_0", "TD0", 0), (1, "U_0", "TD0", 0), (0, "U_90", "TD0", 0), (0, "U_0", "TD90", 0)]
    }
    assert len(set(draws.values())) == len(draws)
    assert all(attempt_rng(*key).standard_normal() == draw for key, draw in draws.items())
    assert attempt_rng(0, "U_0", "TD0", 1).standard_normal() != draws[0, "U_0", "TD0", 0]
