"""The simulated devices keep the protocols, and do in a scene what real ones would."""

import json
import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import trimesh

from voa_fleet.devices.protocol import Arm, SensorRobot
from voa_fleet.devices.simulated import DRIVE_M_S, Scene, SimulatedArm, SimulatedSensorRobot, make_scene
from voa_fleet.errors import UnknownName
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.imperfections import Imperfections, room
from voa_fleet.world.lidar import lidar_geometry, true_ranges
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.object_poses import ObjectPose, scenario_pose
from voa_fleet.world.objects import FleetObject, GripperSetting
from voa_fleet.world.shapes import Box
from voa_fleet.world.ur5e import HOME
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.scenarios import Grasp

ROOM = Imperfections(clutter=room(2.0))


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def scene(mug: FleetObject, clock: VirtualClock) -> Scene:
    return make_scene(mug, clock, 1, ROOM, robots=("one", "two"))


def test_the_simulated_devices_are_devices(scene: Scene) -> None:
    assert isinstance(SimulatedSensorRobot(scene, "one"), SensorRobot)
    assert isinstance(SimulatedArm(scene), Arm)


def test_a_robot_looks_from_where_it_was_sent(mug: FleetObject, scene: Scene) -> None:
    robot = SimulatedSensorRobot(scene, "two", PoseUncertainty(xy_m=0.01, yaw_rad=0.02))
    sensor = mug.scenario.sensors[3]
    scene.put(scenario_pose(mug, "U_135"))
    robot.drive_to(sensor)
    believed = robot.pose()
    assert (believed.x, believed.y, believed.yaw_rad) == (sensor.x, sensor.y, sensor.yaw_rad)
    assert believed.std == PoseUncertainty(xy_m=0.01, yaw_rad=0.02)
    ranges = true_ranges(scene.world, scene.data, lidar_geometry(mug.scenario.lidar), sensor)
    measured = np.array(robot.take_scan().ranges, dtype=np.float64)
    np.testing.assert_allclose(measured, np.where(np.isfinite(ranges), ranges, 0.0), rtol=0.0, atol=1e-6)


def test_driving_and_looking_take_time(mug: FleetObject, scene: Scene, clock: VirtualClock) -> None:
    robot = SimulatedSensorRobot(scene, "one")
    started = clock.now_s()
    robot.drive_to(mug.scenario.sensors[0])
    there = clock.now_s()
    assert there - started > 0.6 / DRIVE_M_S - 0.5
    robot.take_scan()
    assert clock.now_s() == pytest.approx(there + 0.2)
    robot.drive_to(mug.scenario.sensors[0])
    assert clock.now_s() - there < 0.5


def test_a_robot_drives_around_the_object(mug: FleetObject, clock: VirtualClock) -> None:
    places: list[tuple[float, float]] = []

    def watch(data: mujoco.MjData) -> None:
        x, y, _ = data.mocap_pos[0]
        places.append((float(x), float(y)))

    scene = make_scene(mug, clock, 1, ROOM, watch=watch)
    robot = SimulatedSensorRobot(scene, "robot")
    robot.drive_to(mug.scenario.sensors[0])
    places.clear()
    robot.drive_to(mug.scenario.sensors[4])
    assert min(math.hypot(x, y) for x, y in places) > 0.39
    assert places[-1] == pytest.approx((mug.scenario.sensors[4].x, mug.scenario.sensors[4].y))
    steps = np.diff(np.array(places), axis=0)
    assert np.hypot(steps[:, 0], steps[:, 1]).max() < 1.1 * DRIVE_M_S * 0.05


def true_place(robot: SimulatedSensorRobot) -> tuple[float, float]:
    """The x (metres) and yaw (radians) at which a robot stands in the simulation, which it does not know itself."""
    scene = robot.scene
    mocap = scene.world.mocaps[0]
    w, _, _, z = scene.data.mocap_quat[mocap]
    return float(scene.data.mocap_pos[mocap][0]), 2.0 * math.atan2(z, w)


def test_a_robot_does_not_know_its_error(mug: FleetObject, clock: VirtualClock) -> None:
    imperfections = Imperfections(robot_xy_m=0.02, robot_yaw_rad=0.05)
    robot = SimulatedSensorRobot(make_scene(mug, clock, 1, imperfections), "robot")
    errors = []
    for _ in range(60):
        robot.drive_to(mug.scenario.sensors[0])
        x, yaw_rad = true_place(robot)
        errors.append((x - robot.pose().x, yaw_rad - robot.pose().yaw_rad))
    assert np.std(errors, axis=0) == pytest.approx([0.02, 0.05], rel=0.3)


def test_the_arm_grasps_what_it_can_and_goes_home_if_it_fails(mug: FleetObject, scene: Scene) -> None:
    arm = SimulatedArm(scene)
    assert arm.reachable() == ("TD0", "TD90", "OI90", "TDH0")
    scene.put(scenario_pose(mug, "U_90"))
    failed = arm.attempt("TDH0")
    assert (failed.success, failed.detail) == (False, "nothing between the fingers")
    np.testing.assert_allclose(scene.data.qpos[scene.world.joints], HOME, rtol=0.0, atol=0.02)
    done = arm.attempt("OI90")
    assert (done.grasp, done.success, done.detail) == ("OI90", True, "lifted")
    assert scene.world.object_pose(scene.data).position[2] > 0.1


def tall_box(like: FleetObject) -> FleetObject:
    """A box of 5 by 5 by 20 cm upright at the origin, with grasps from the side, from all around."""
    box = Box(kind="box", centre=(0.0, 0.0, 0.1), size=(0.05, 0.05, 0.2))
    gripper = GripperSetting(opening_m=0.085, force_n=40.0)
    physics = like.physics.model_copy(update={"solids": [box], "gripper": gripper})
    shape = trimesh.creation.box(bounds=[[-0.025, -0.025, 0.0], [0.025, 0.025, 0.2]])
    mesh = Mesh(np.array(shape.vertices), np.array(shape.faces, dtype=np.int32))
    grasps = {
        f"from {yaw}": GraspGeometry(
            tool_centre_point=(0.0, 0.0, 0.08),
            approach=(-math.cos(math.radians(yaw)), -math.sin(math.radians(yaw)), 0.0),
            closing=(-math.sin(math.radians(yaw)), math.cos(math.radians(yaw)), 0.0),
        )
        for yaw in (90, 180, 270)
    }
    scenario = like.scenario.model_copy(update={"grasps": [Grasp(name=name) for name in grasps]})
    return replace(like, physics=physics, mesh=mesh, scenario=scenario, geometries=grasps)


@pytest.mark.parametrize("grasp", ["from 90", "from 180", "from 270"])
def test_the_arm_sweeps_no_object_off_its_place(mug: FleetObject, clock: VirtualClock, grasp: str) -> None:
    scene = make_scene(tall_box(mug), clock, 0, Imperfections())
    scene.put(ObjectPose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)))
    outcome = SimulatedArm(scene).attempt(grasp)
    assert (outcome.success, outcome.detail) == (True, "lifted")


def test_a_failed_attempt_says_how_far_the_object_moved(targets: dict[str, FleetObject], clock: VirtualClock) -> None:
    scene = make_scene(targets["block"], clock, 1, Imperfections())
    scene.put(scenario_pose(targets["block"], "U_0"))
    outcome = SimulatedArm(scene).attempt("OI90")
    assert not outcome.success
    assert outcome.moved_m is not None
    assert outcome.moved_m > 0.01


def test_a_grasp_or_robot_that_does_not_exist_is_refused(scene: Scene) -> None:
    with pytest.raises(UnknownName, match="no grasp 'X'; there are: TD0"):
        SimulatedArm(scene).attempt("X")
    with pytest.raises(UnknownName, match="no robot 'three'; there are: one, two"):
        SimulatedSensorRobot(scene, "three")


def test_a_robot_that_is_placed_has_the_errors_of_one_that_drives(mug: FleetObject, clock: VirtualClock) -> None:
    imperfections, sensor = Imperfections(robot_xy_m=0.02, robot_yaw_rad=0.05), mug.scenario.sensors[2]
    driven, placed = (SimulatedSensorRobot(make_scene(mug, clock, 1, imperfections), "robot") for _ in range(2))
    driven.drive_to(sensor)
    before = clock.now_s()
    placed.stand_at(sensor)
    assert clock.now_s() == before
    assert (true_place(placed), placed.pose()) == (true_place(driven), driven.pose())
    assert placed.take_scan() == driven.take_scan()


def test_the_same_seed_gives_the_same_episode(mug: FleetObject) -> None:
    imperfections = Imperfections.of_lds_01()

    def episode() -> str:
        scene = make_scene(mug, VirtualClock(), 5, imperfections)
        robot, arm = SimulatedSensorRobot(scene, "robot"), SimulatedArm(scene)
        scene.put(scenario_pose(mug, "U_45"))
        robot.drive_to(mug.scenario.sensors[2])
        return json.dumps([robot.take_scan().model_dump(), arm.attempt("TD90").detail])

    assert episode() == episode()
