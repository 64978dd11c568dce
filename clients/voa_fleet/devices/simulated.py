"""Simulated devices: sensor robots and an arm that share one scene.

They know the world in which they move, and nothing of the service. Their methods are called from one thread at a time.
"""

import math
from dataclasses import dataclass, field

import mujoco
import numpy as np

from voa_fleet.devices.protocol import GraspOutcome
from voa_fleet.errors import UnknownName
from voa_fleet.world.attempts import Watch, open_fingers, perform
from voa_fleet.world.clocks import Clock
from voa_fleet.world.frames import Floats, yaw_quaternion
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import CONTROL_S, CONTROL_STEPS, GraspPlan, commands, joint_move, plan_grasp
from voa_fleet.world.lidar import (
    REVOLUTION_S,
    LidarGeometry,
    displaced,
    lidar_geometry,
    scan_message,
    true_ranges,
    with_errors,
)
from voa_fleet.world.object_poses import ObjectPose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World, build_world
from voa_fleet.world.ur5e import HOME
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration, SensorPose, UncertainSensorPose
from voa_msgs.sessions import Scan

DRIVE_M_S = 0.22
"""Speed of a robot: a TurtleBot3 Burger at its fastest."""
ARM_RAD_S = 1.0
PARKED_M = 1.0
"""Distance from the object at which robots wait."""
_DRIVE_STEP_S = 0.05


def unwatched(_data: mujoco.MjData) -> None:
    """Do nothing with a new state of the scene."""


@dataclass(frozen=True, eq=False)
class Scene:
    """State of one world: the object on the table, robots and arm around it.

    Attributes:
        world: the model.
        data: its state.
        clock: by which time passes in the scene.
        rng: of all errors.
        imperfections: sizes of the errors.
        watch: called with the state whenever something has moved.
    """

    world: World
    data: mujoco.MjData
    clock: Clock
    rng: np.random.Generator
    imperfections: Imperfections
    watch: Watch = unwatched

    def moved(self, seconds: float) -> None:
        """Let time pass, then call `watch` with the new state."""
        self.clock.sleep(seconds)
        self.watch(self.data)

    def put(self, place: ObjectPose) -> None:
        """Place the object, and send arm and robots back to where they wait, all at once."""
        mujoco.mj_resetData(self.world.model, self.data)
        self.data.qpos[self.world.joints] = HOME
        self.data.ctrl[self.world.servos] = HOME
        open_fingers(self.world, self.data)
        self.world.put_object(self.data, place)
        count = len(self.world.robots)
        for index in range(count):
            self.put_robot(index, parked(index, count))
        mujoco.mj_forward(self.world.model, self.data)
        self.watch(self.data)

    def put_robot(self, index: int, pose: SensorPose) -> None:
        """Place the lidar of the robot with that index at a pose, at once."""
        mocap = self.world.mocaps[index]
        self.data.mocap_pos[mocap] = [pose.x, pose.y, self.world.object.lidar_height_m]
        self.data.mocap_quat[mocap] = yaw_quaternion(pose.yaw_rad)


def parked(index: int, count: int) -> SensorPose:
    """Return the pose at which the robot with that index, of `count` robots, waits: facing the object, 1 m away."""
    bearing = 2.0 * math.pi * (index + 0.5) / count
    return SensorPose(x=PARKED_M * math.cos(bearing), y=PARKED_M * math.sin(bearing), yaw_rad=bearing + math.pi)


def make_scene(
    target: FleetObject,
    clock: Clock,
    seed: int,
    imperfections: Imperfections,
    *,
    robots: tuple[str, ...] = ("robot",),
    watch: Watch = unwatched,
) -> Scene:
    """Build a scene with the object exactly at its first pose.

    Args:
        target: the object.
        clock: by which time passes in the scene.
        seed: of all errors.
        imperfections: sizes of the errors, and the clutter.
        robots: names of the lidar robots.
        watch: called with the state whenever something has moved.
    """
    world = build_world(target, robots=robots, clutter=imperfections.clutter)
    scene = Scene(world, mujoco.MjData(world.model), clock, np.random.default_rng(seed), imperfections, watch)
    scene.put(scenario_pose(target, target.poses[0]))
    return scene


@dataclass(eq=False)
class SimulatedSensorRobot:
    """A simulated lidar robot. It believes to be where it was sent; its true pose has the errors of the scene.

    Attributes:
        scene: in which it moves.
        name: one of the world's robots.
        stated: the standard deviations that it states with its pose; None: it states none.
    """

    scene: Scene
    name: str
    stated: PoseUncertainty | None = None
    _lidar: LidarGeometry = field(init=False)
    _index: int = field(init=False)
    _believed: SensorPose = field(init=False)
    _true: SensorPose = field(init=False)

    def __post_init__(self) -> None:
        robots = self.scene.world.robots
        if self.name not in robots:
            raise UnknownName("robot", self.name, list(robots))
        self._index = robots.index(self.name)
        self._lidar = lidar_geometry(self.scene.world.object.scenario.lidar)
        self._true = self._believed = parked(self._index, len(robots))

    def drive_to(self, sensor: SensorConfiguration) -> None:
        """Drive around the object, then in or out, to a sensor configuration, with the errors of the scene."""
        goal = displaced(sensor, self.scene.imperfections, self.scene.rng)
        for pose in _path(self._true, goal):
            self.scene.put_robot(self._index, pose)
            mujoco.mj_kinematics(self.scene.world.model, self.scene.data)
            self.scene.moved(_DRIVE_STEP_S)
        self._arrive(sensor, goal)

    def stand_at(self, sensor: SensorConfiguration) -> None:
        """Place the robot at a sensor configuration at once, with the errors of the scene but without the drive."""
        goal = displaced(sensor, self.scene.imperfections, self.scene.rng)
        self.scene.put_robot(self._index, goal)
        self._arrive(sensor, goal)

    def _arrive(self, sensor: SensorConfiguration, goal: SensorPose) -> None:
        self._true = goal
        self._believed = SensorPose(x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m)

    def pose(self) -> UncertainSensorPose:
        """Return the pose at which the robot believes to be, with the standard deviations that it states."""
        return UncertainSensorPose(**self._believed.model_dump(), std=self.stated)

    def take_scan(self) -> Scan:
        """Take a scan of one revolution, with the errors of the scene, as the message for the service."""
        return scan_message(self.measure())

    def measure(self) -> Floats:
        """Measure one revolution with the errors of the scene: (beams,), metres, not rounded; 0 where no return."""
        self.scene.moved(REVOLUTION_S)
        mujoco.mj_kinematics(self.scene.world.model, self.scene.data)
        ranges = true_ranges(self.scene.world, self.scene.data, self._lidar, self._true)
        return with_errors(ranges, self._lidar, self.scene.imperfections, self.scene.rng)


@dataclass(eq=False)
class SimulatedArm:
    """The simulated arm of a scene. Each plan of a grasp is made when it is first needed, and kept."""

    scene: Scene
    name: str = "arm"
    _plans: dict[str, GraspPlan | None] = field(default_factory=dict)

    def reachable(self) -> tuple[str, ...]:
        """Return the names of the grasps for which the arm has joint angles."""
        return tuple(grasp for grasp in self.scene.world.object.grasps if self.plan(grasp) is not None)

    def attempt(self, grasp: str) -> GraspOutcome:
        """Move to the grasp, close, lift; where that failed, open the fingers and return home.

        Between home and the grasp the hand comes and goes straight over the place where its approach begins, so that it
        sweeps no object off its place.

        Raises:
            UnknownName: there is no such grasp.
            UnstableSimulation: the simulation became unstable.
        """
        plan = self.plan(grasp)
        if plan is None:
            return GraspOutcome(grasp, success=False, detail="out of reach")
        world, data = self.scene.world, self.scene.data
        before = np.array(world.object_pose(data).position[:2])
        opened = world.object.physics.gripper.opening_m / 2.0
        data.ctrl[world.grip] = opened
        self._go(plan.descent[0])
        self._follow(plan.descent)
        attempt = perform(world, data, plan, lambda _data: self.scene.moved(CONTROL_S))
        if not attempt.success:
            data.ctrl[world.grip] = opened
            self._go(plan.approach[0])
            self._follow(plan.descent[::-1])
            self._go(np.array(HOME))
        after = np.array(world.object_pose(data).position[:2])
        return GraspOutcome(grasp, attempt.success, attempt.result, float(np.linalg.norm(after - before)))

    def plan(self, grasp: str) -> GraspPlan | None:
        """Return the motion to a grasp and up from it; None where it is out of reach; raises UnknownName."""
        if grasp not in self._plans:
            self._plans[grasp] = plan_grasp(self.scene.world, self.scene.world.object.grasp(grasp))
        return self._plans[grasp]

    def _go(self, joints: Floats) -> None:
        world, data = self.scene.world, self.scene.data
        self._follow(joint_move(data.qpos[world.joints].copy(), joints, ARM_RAD_S))

    def _follow(self, joints: Floats) -> None:
        world, data = self.scene.world, self.scene.data
        for row in commands(joints):
            data.ctrl[world.servos] = row
            world.step(data, CONTROL_STEPS)
            self.scene.moved(CONTROL_S)


def _path(start: SensorPose, goal: SensorPose) -> list[SensorPose]:
    """Poses 50 ms apart; bearing and distance from the object change evenly, the shorter way round."""
    distances = math.hypot(start.x, start.y), math.hypot(goal.x, goal.y)
    bearing = math.atan2(start.y, start.x)
    around = math.remainder(math.atan2(goal.y, goal.x) - bearing, 2.0 * math.pi)
    turn = math.remainder(goal.yaw_rad - start.yaw_rad, 2.0 * math.pi)
    length = math.hypot(max(distances) * around, distances[1] - distances[0])
    count = max(1, math.ceil(length / DRIVE_M_S / _DRIVE_STEP_S))
    path = []
    for step in range(1, count):
        share = step / count
        distance = distances[0] + share * (distances[1] - distances[0])
        angle = bearing + share * around
        path.append(
            SensorPose(x=distance * math.cos(angle), y=distance * math.sin(angle), yaw_rad=start.yaw_rad + share * turn)
        )
    return [*path, goal]
