"""The skeleton of real devices: with scripted drivers it runs an episode, and says what is wrong where one fails."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_fleet.devices.example import LIDAR_ON_ROBOT, ExampleArm, ExampleSensorRobot
from voa_fleet.devices.protocol import Arm, DeviceError, SensorRobot
from voa_fleet.devices.simulated import SimulatedSensorRobot, make_scene
from voa_fleet.episodes.episode import Pair, run_episode
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.policies import policy_named
from voa_fleet.errors import UnknownName
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.imperfections import Imperfections, room
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import FleetObject


@dataclass
class ScriptedBase:
    """A base that arrives where it is sent, off by `error_m` in x; or gives up."""

    error_m: float = 0.0
    gives_up: bool = False
    here: tuple[float, float, float] = (1.0, 0.0, math.pi)
    goals: list[tuple[float, float, float]] = field(default_factory=list)

    def go_to(self, x: float, y: float, yaw_rad: float) -> bool:
        self.goals.append((x, y, yaw_rad))
        self.here = x + self.error_m, y, yaw_rad
        return not self.gives_up

    def pose(self) -> tuple[float, float, float]:
        return self.here

    def standard_deviations(self) -> tuple[float, float]:
        return 0.002, 0.005


@dataclass
class ScriptedLidar:
    """A lidar that measures in a simulated scene, from where the script has put it."""

    robot: SimulatedSensorRobot
    base: ScriptedBase
    mug: FleetObject
    turns: bool = True

    def revolution(self, timeout_s: float) -> list[float] | None:
        if not self.turns:
            return None
        lidar = ExampleSensorRobot(self.base, self).pose()
        nearest = min(self.mug.scenario.sensors, key=lambda sensor: math.hypot(sensor.x - lidar.x, sensor.y - lidar.y))
        self.robot.stand_at(nearest)
        return [float(value or 0.0) for value in self.robot.take_scan().ranges]


@dataclass
class ScriptedArm:
    """An arm whose fingers hold the object with some programs only."""

    width_m: dict[str, float]
    runs: list[str] = field(default_factory=list)

    def run_program(self, name: str) -> bool:
        self.runs.append(name)
        return name in self.width_m

    def grip_width_m(self) -> float:
        return self.width_m[self.runs[-1]]


@pytest.fixture
def base() -> ScriptedBase:
    return ScriptedBase()


@pytest.fixture
def lidar(mug: FleetObject, base: ScriptedBase) -> ScriptedLidar:
    scene = make_scene(mug, VirtualClock(), 0, Imperfections(clutter=room(2.0)))
    scene.put(scenario_pose(mug, "U_90"))
    return ScriptedLidar(SimulatedSensorRobot(scene, "robot"), base, mug)


def test_they_have_the_methods_of_devices(base: ScriptedBase, lidar: ScriptedLidar) -> None:
    assert isinstance(ExampleSensorRobot(base, lidar), SensorRobot)
    assert isinstance(ExampleArm(ScriptedArm({})), Arm)


def test_an_episode_with_scripted_drivers(
    process: str, mug: FleetObject, base: ScriptedBase, lidar: ScriptedLidar
) -> None:
    robot = ExampleSensorRobot(base, lidar)
    driver = ScriptedArm({"grasp_td90": 0.0, "grasp_oi90": 0.004})
    arm = ExampleArm(driver, {"TD90": "grasp_td90", "OI90": "grasp_oi90"})
    with Client(process) as client:
        scenario = load_scenario(client, mug.folder / "scenario.json")
        pair = Pair("lab", client, robot, arm, client_channel(client, robot, scenario, 3), VirtualClock())
        episode = run_episode(pair, scenario, policy_named("voa"))
        kinds = [entry.kind for entry in client.history(episode.before.id)]
    assert len(episode.looks) == len(base.goals) >= 1
    assert (episode.grasp, episode.success) == ("OI90", True)  # without a look it would have been TD90
    assert driver.runs == ["grasp_oi90"]
    assert kinds == ["prior", *["scan"] * len(episode.looks), "outcome"]


def test_the_lidar_is_where_it_was_sent_and_not_the_base(
    mug: FleetObject, base: ScriptedBase, lidar: ScriptedLidar
) -> None:
    robot, sensor = ExampleSensorRobot(base, lidar), mug.scenario.sensors[3]
    robot.drive_to(sensor)
    pose = robot.pose()
    assert (pose.x, pose.y, pose.yaw_rad) == pytest.approx((sensor.x, sensor.y, sensor.yaw_rad))
    ((x, y, _),) = base.goals
    assert math.hypot(x - sensor.x, y - sensor.y) == pytest.approx(float(np.hypot(*LIDAR_ON_ROBOT)))
    assert pose.std is not None
    assert (pose.std.xy_m, pose.std.yaw_rad) == (0.002, 0.005)


def test_what_fails_is_reported(mug: FleetObject, base: ScriptedBase, lidar: ScriptedLidar) -> None:
    sensor = mug.scenario.sensors[0]
    with pytest.raises(DeviceError, match=f"navigation to {sensor.name} failed"):
        ExampleSensorRobot(ScriptedBase(gives_up=True), lidar).drive_to(sensor)
    with pytest.raises(DeviceError, match=r"expected to stop within 0\.05 m of .*, got 0\.200 m"):
        ExampleSensorRobot(ScriptedBase(error_m=0.2), lidar).drive_to(sensor)
    lidar.turns = False
    with pytest.raises(DeviceError, match=r"no scan within 2\.0 s"):
        ExampleSensorRobot(base, lidar).take_scan()
    arm = ExampleArm(ScriptedArm({}), {"TD0": "grasp_td0"})
    with pytest.raises(UnknownName, match="no program for the grasp 'TD90'; there are: TD0"):
        arm.attempt("TD90")
    with pytest.raises(DeviceError, match="the controller stopped the program 'grasp_td0'"):
        arm.attempt("TD0")


class FixedLidar:
    """A lidar that measures the same ranges at every revolution."""

    def __init__(self, *ranges: float) -> None:
        self._ranges = ranges

    def revolution(self, timeout_s: float) -> tuple[float, ...]:
        return self._ranges


def test_beams_with_nothing_in_range_and_beams_without_a_measurement_differ() -> None:
    robot = ExampleSensorRobot(ScriptedBase(), FixedLidar(0.5, math.inf, math.nan, -math.inf, 1.5))
    scan = robot.take_scan()
    assert (scan.ranges, scan.no_return) == ([0.5, None, None, None, 1.5], [1])
