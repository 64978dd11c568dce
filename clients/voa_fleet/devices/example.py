"""A skeleton of real devices: copy it, and fill in the places marked with FILL IN.

The classes below work as they are with any drivers that have the few methods of `BaseDriver`, `LidarDriver` and
`ArmDriver`; the tests run an episode with scripted ones. Replace the drivers by your own: an action client of Nav2, a
subscriber of /scan and /amcl_pose, a program on the arm's controller. To run an episode with them:

    with Client("http://lab:8000") as client:
        scenario = load_scenario(client, Path("scenario.json"))
        robot = ExampleSensorRobot(my_base, my_lidar)
        channel = client_channel(client, robot, scenario)
        pair = Pair("lab", client, robot, ExampleArm(my_arm), channel, RealClock())
        episode = run_episode(pair, scenario, policy_named("voa"))
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from voa_fleet.devices.protocol import DeviceError, GraspOutcome
from voa_fleet.errors import UnknownName
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration, UncertainSensorPose
from voa_msgs.sessions import Scan

ARRIVED_M = 0.05
"""Largest distance from the goal at which the robot has arrived. FILL IN (1): the tolerance of your navigation."""
LIDAR_ON_ROBOT = (-0.032, 0.0)
"""Position of the lidar in the robot's frame, x forward and y left, metres. FILL IN (2): measure it on your robot."""


class BaseDriver(Protocol):
    """Driver of a mobile base, as a navigation stack offers it."""

    def go_to(self, x: float, y: float, yaw_rad: float) -> bool:
        """Drive the base to a pose in the world frame and wait; True if the goal was reached."""

    def pose(self) -> tuple[float, float, float]:
        """Return the base's x, y (metres) and yaw (radians) in the world frame, as localisation estimates them."""

    def standard_deviations(self) -> tuple[float, float]:
        """Return the standard deviations of the pose: of x and y (metres), and of the yaw (radians)."""


class LidarDriver(Protocol):
    """Driver of a lidar."""

    def revolution(self, timeout_s: float) -> Sequence[float] | None:
        """Return the ranges of the next revolution, metres, as REP-117 has them; None where none comes in time.

        inf is a beam with nothing in range, NaN or -inf one without a measurement.
        """


class ArmDriver(Protocol):
    """Driver of an arm with a gripper."""

    def run_program(self, name: str) -> bool:
        """Run a program of the controller; True if it ended without a protective stop."""

    def grip_width_m(self) -> float:
        """Return the distance between the closed fingers, metres."""


@dataclass
class ExampleSensorRobot:
    """A mobile base with a lidar.

    Attributes:
        base: drives.
        lidar: measures.
        name: of the robot; where its scans come by ROS 2, the namespace of its topics.
        scan_timeout_s: for which a revolution is waited for.
    """

    base: BaseDriver
    lidar: LidarDriver
    name: str = "robot"
    scan_timeout_s: float = 2.0

    def drive_to(self, sensor: SensorConfiguration) -> None:
        """Drive until the lidar is at a sensor configuration.

        Raises:
            DeviceError: navigation gave up, or the robot stopped too far away.
        """
        x, y = _offset(sensor.x, sensor.y, sensor.yaw_rad, sign=-1.0)
        if not self.base.go_to(x, y, sensor.yaw_rad):
            raise DeviceError(f"{self.name}: navigation to {sensor.name} failed; is the way free?")
        here_x, here_y, _ = self.base.pose()
        away = ((here_x - x) ** 2 + (here_y - y) ** 2) ** 0.5
        if away > ARRIVED_M:
            raise DeviceError(f"{self.name}: expected to stop within {ARRIVED_M} m of {sensor.name}, got {away:.3f} m")

    def pose(self) -> UncertainSensorPose:
        """Return the lidar's pose from the base's, with the standard deviations of localisation."""
        base_x, base_y, yaw = self.base.pose()
        x, y = _offset(base_x, base_y, yaw, sign=1.0)
        xy_m, yaw_rad = self.base.standard_deviations()
        return UncertainSensorPose(x=x, y=y, yaw_rad=yaw, std=PoseUncertainty(xy_m=xy_m, yaw_rad=yaw_rad))

    def take_scan(self) -> Scan:
        """Take a scan of one revolution.

        Raises:
            DeviceError: the lidar sends nothing.
        """
        ranges = self.lidar.revolution(self.scan_timeout_s)
        if ranges is None:
            raise DeviceError(f"{self.name}: no scan within {self.scan_timeout_s} s; does the lidar turn?")
        # FILL IN (3): where beams are not those of the scenario's lidar, state angle_min and angle_increment as well.
        return Scan(
            ranges=[float(value) if math.isfinite(value) else None for value in ranges],
            no_return=[index for index, value in enumerate(ranges) if value == math.inf],
        )


@dataclass
class ExampleArm:
    """An arm whose controller has a program for each grasp of the scenario.

    Attributes:
        driver: runs the programs.
        programs: name of the controller's program for each grasp. FILL IN (4): one per grasp of your scenario.
        name: of the arm.
        thinnest_m: thinnest part of the object that the fingers may hold.
    """

    driver: ArmDriver
    programs: Mapping[str, str] = field(default_factory=dict)
    name: str = "arm"
    thinnest_m: float = 0.002

    def reachable(self) -> tuple[str, ...]:
        """Return the names of the grasps that have a program."""
        return tuple(self.programs)

    def attempt(self, grasp: str) -> GraspOutcome:
        """Run the program of a grasp; the object is lifted if the fingers did not close completely.

        Raises:
            UnknownName: the grasp has no program.
            DeviceError: the controller stopped the program.
        """
        if grasp not in self.programs:
            raise UnknownName("program for the grasp", grasp, list(self.programs))
        if not self.driver.run_program(self.programs[grasp]):
            raise DeviceError(f"{self.name}: the controller stopped the program {self.programs[grasp]!r}")
        held = self.driver.grip_width_m() > self.thinnest_m
        return GraspOutcome(grasp, held, "lifted" if held else "nothing between the fingers")


def _offset(x: float, y: float, yaw_rad: float, sign: float) -> tuple[float, float]:
    """Position of the lidar from that of the base (sign 1), or of the base from that of the lidar (sign -1)."""
    forward, left = LIDAR_ON_ROBOT
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    return x + sign * (cosine * forward - sine * left), y + sign * (sine * forward + cosine * left)
