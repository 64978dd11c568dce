"""The simulated devices: sensor robots and an arm that share one scene.

They know the world they move in and nothing of the service. Whoever calls them does so from one thread at a time.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import mujoco
import numpy as np

from voa_fleet.devices.clocks import Clock
from voa_fleet.devices.protocol import GraspOutcome
from voa_fleet.episodes.attempts import noisy_pose, object_pose, open_fingers, perform
from voa_fleet.errors import UnknownName
from voa_fleet.world.frames import Floats, yaw_quaternion
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import CONTROL_S, CONTROL_STEPS, GraspPlan, commands, joint_move, plan_grasp
from voa_fleet.world.lidar import REVOLUTION_S, LidarGeometry, lidar_geometry, scan_message, true_ranges, with_faults
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World, build_world
from voa_fleet.world.ur5e import HOME
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration, SensorPose, UncertainSensorPose
from voa_msgs.sessions import Scan

DRIVE_M_S = 0.22
"""A TurtleBot3 Burger at its fastest."""
ARM_RAD_S = 1.0
PARKED_M = 1.0
"""From the object: where robots wait."""
_DRIVE_STEP_S = 0.05

Watch = Callable[[mujoco.MjData], None]
"""Called whenever the scene has moved on: to draw it."""


def _unwatched(_data: mujoco.MjData) -> None:
    """Nobody looks."""


@dataclass(frozen=True, eq=False)
class Scene:
    """One world as it stands: the object somewhere, robots and arm around it.

    Attributes:
        world: the model.
        data: its state.
        clock: whose time passes.
        rng: of everything that goes wrong.
        flaws: how it goes wrong.
        watch: told whenever something has moved.
    """

    world: World
    data: mujoco.MjData
    clock: Clock
    rng: np.random.Generator
    flaws: Imperfections
    watch: Watch = _unwatched

    def moved(self, seconds: float) -> None:
        """Let time pass and tell who watches."""
        self.clock.sleep(seconds)
        self.watch(self.data)

    def put(self, pose: str) -> None:
        """Place the object at a pose of the scenario, as exactly as the imperfections allow, and the arm at home.

        Raises:
            UnknownName: there is no such pose.
        """
        mujoco.mj_resetData(self.world.model, self.data)
        self.data.qpos[self.world.joints] = HOME
        self.data.ctrl[self.world.servos] = HOME
        open_fingers(self.world, self.data)
        exact = object_pose(self.world.object, pose)
        self.world.put_object(self.data, noisy_pose(exact, self.flaws, self.rng))
        for index in range(len(self.world.robots)):
            bearing = 2.0 * math.pi * (index + 0.5) / len(self.world.robots)
            self.put_robot(index, PARKED_M * math.cos(bearing), PARKED_M * math.sin(bearing), bearing + math.pi)
        mujoco.mj_forward(self.world.model, self.data)
        self.watch(self.data)

    def put_robot(self, index: int, x: float, y: float, yaw_rad: float) -> None:
        """Place a robot's lidar, metres and radians."""
        mocap = self.world.mocaps[index]
        self.data.mocap_pos[mocap] = [x, y, self.world.object.lidar_height_m]
        self.data.mocap_quat[mocap] = yaw_quaternion(yaw_rad)


def make_scene(
    thing: FleetObject,
    clock: Clock,
    seed: int,
    flaws: Imperfections,
    *,
    robots: tuple[str, ...] = ("robot",),
    watch: Watch | None = None,
) -> Scene:
    """A scene with the object at its first pose."""
    world = build_world(thing, robots=robots, clutter=flaws.clutter)
    scene = Scene(world, mujoco.MjData(world.model), clock, np.random.default_rng(seed), flaws, watch or _unwatched)
    scene.put(thing.poses[0])
    return scene


@dataclass(eq=False)
class SimulatedSensorRobot:
    """A lidar robot. It believes to stand where it was sent; where it stands is off by the imperfections.

    Attributes:
        scene: that it is in.
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
        if self.name not in self.scene.world.robots:
            raise UnknownName("robot", self.name, list(self.scene.world.robots))
        self._index = self.scene.world.robots.index(self.name)
        self._lidar = lidar_geometry(self.scene.world.object.scenario.lidar)
        bearing = 2.0 * math.pi * (self._index + 0.5) / len(self.scene.world.robots)
        x, y = PARKED_M * math.cos(bearing), PARKED_M * math.sin(bearing)
        self._true = self._believed = SensorPose(x=x, y=y, yaw_rad=bearing + math.pi)

    def drive_to(self, sensor: SensorConfiguration) -> None:
        """Drive around the object, then in or out; the lidar stands where it should but for the imperfections."""
        dx, dy, turn = (float(number) for number in self.scene.rng.standard_normal(3))
        goal = SensorPose(
            x=sensor.x + dx * self.scene.flaws.robot_xy_m,
            y=sensor.y + dy * self.scene.flaws.robot_xy_m,
            yaw_rad=sensor.yaw_rad + turn * self.scene.flaws.robot_yaw_rad,
            height_m=sensor.height_m,
        )
        for x, y, yaw in _way(self._true, goal):
            self.scene.put_robot(self._index, x, y, yaw)
            mujoco.mj_kinematics(self.scene.world.model, self.scene.data)
            self.scene.moved(_DRIVE_STEP_S)
        self._true = goal
        self._believed = SensorPose(x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m)

    def pose(self) -> UncertainSensorPose:
        """Where it believes to be."""
        return UncertainSensorPose(**self._believed.model_dump(), std=self.stated)

    @property
    def true_pose(self) -> SensorPose:
        """Where it is: for evaluations; a real robot does not know."""
        return self._true

    def take_scan(self) -> Scan:
        """One revolution, with all its faults."""
        self.scene.moved(REVOLUTION_S)
        mujoco.mj_kinematics(self.scene.world.model, self.scene.data)
        ranges = true_ranges(self.scene.world, self.scene.data, self._lidar, self._true)
        return scan_message(with_faults(ranges, self._lidar, self.scene.flaws, self.scene.rng))


@dataclass(eq=False)
class SimulatedArm:
    """The arm of a scene. Plans are made when they are first needed, and kept."""

    scene: Scene
    name: str = "arm"
    _plans: dict[str, GraspPlan | None] = field(default_factory=dict)

    def reachable(self) -> tuple[str, ...]:
        """The grasps for which the arm has joint angles."""
        return tuple(grasp for grasp in self.scene.world.object.grasps if self._plan(grasp) is not None)

    def attempt(self, grasp: str) -> GraspOutcome:
        """From where the arm is to the grasp, close, lift; then, if that failed, home with open fingers."""
        plan = self._plan(grasp)
        if plan is None:
            return GraspOutcome(grasp, success=False, detail="out of reach")
        world, data = self.scene.world, self.scene.data
        before = np.array(world.object_pose(data).position[:2])
        open_fingers_now = world.object.physics.gripper.opening_m / 2.0
        data.ctrl[world.grip] = open_fingers_now
        self._go(plan.approach[0])
        attempt = perform(world, data, plan, lambda _data: self.scene.moved(CONTROL_S))
        if not attempt.success:
            data.ctrl[world.grip] = open_fingers_now
            self._go(plan.approach[0])
            self._go(np.array(HOME))
        after = np.array(world.object_pose(data).position[:2])
        return GraspOutcome(grasp, attempt.success, attempt.result, float(np.linalg.norm(after - before)))

    def _plan(self, grasp: str) -> GraspPlan | None:
        if grasp not in self._plans:
            self._plans[grasp] = plan_grasp(self.scene.world, self.scene.world.object.grasp(grasp))
        return self._plans[grasp]

    def _go(self, joints: Floats) -> None:
        world, data = self.scene.world, self.scene.data
        for row in commands(joint_move(data.qpos[world.joints].copy(), joints, ARM_RAD_S)):
            data.ctrl[world.servos] = row
            world.step(data, CONTROL_STEPS)
            self.scene.moved(CONTROL_S)


def _way(start: SensorPose, goal: SensorPose) -> list[tuple[float, float, float]]:
    """Places (x, y, yaw), 50 ms apart: bearing and distance from the object change evenly, the shorter way round."""
    distances = math.hypot(start.x, start.y), math.hypot(goal.x, goal.y)
    bearing = math.atan2(start.y, start.x)
    around = math.remainder(math.atan2(goal.y, goal.x) - bearing, 2.0 * math.pi)
    turn = math.remainder(goal.yaw_rad - start.yaw_rad, 2.0 * math.pi)
    length = math.hypot(max(distances) * around, distances[1] - distances[0])
    count = max(1, math.ceil(length / DRIVE_M_S / _DRIVE_STEP_S))
    way = []
    for step in range(1, count + 1):
        share = step / count
        distance = distances[0] + share * (distances[1] - distances[0])
        angle = bearing + share * around
        way.append((distance * math.cos(angle), distance * math.sin(angle), start.yaw_rad + share * turn))
    return [*way[:-1], (goal.x, goal.y, goal.yaw_rad)]
