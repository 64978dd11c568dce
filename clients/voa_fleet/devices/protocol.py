"""Devices: what the fleet asks of a sensor robot and of an arm, simulated or real.

For each device there is a protocol (here), a simulated one (`simulated`), and a place for a real one: a module of
your own with a class that has the protocol's methods, made by a function without arguments. Name that function
where the fleet takes a device, as in `my_lab.turtlebot:connect`, and `device_of` finds it:

    # my_lab/turtlebot.py
    class TurtleBot:
        name = "turtlebot"
        def drive_to(self, sensor): ...       # send a goal to Nav2, wait until it is reached
        def pose(self): ...                   # from AMCL: the lidar's own pose and its standard deviations
        def take_scan(self): ...              # one sensor_msgs/LaserScan as the driver gave it

    def connect():
        return TurtleBot()

A real device may block for as long as it needs, and raises `DeviceError` where it cannot do what it is asked.
"""

import importlib
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from voa_fleet.errors import FleetError, UnknownName
from voa_msgs.geometry import SensorConfiguration, UncertainSensorPose
from voa_msgs.sessions import Scan


class DeviceError(FleetError):
    """A device cannot do what it is asked; says why."""


@dataclass(frozen=True)
class GraspOutcome:
    """What came of a grasp that was attempted.

    Attributes:
        success: whether the object was lifted.
        detail: how it ended, in words; "" where the device does not know.
        moved_m: how far the object has moved over the table, where that is known.
    """

    grasp: str
    success: bool
    detail: str = ""
    moved_m: float | None = None


@runtime_checkable
class SensorRobot(Protocol):
    """A robot that drives a lidar around the table."""

    name: str

    def drive_to(self, sensor: SensorConfiguration) -> None:
        """Bring the lidar to a sensor configuration; returns when the robot stands still there, as far as it knows.

        Raises:
            DeviceError: it cannot get there.
        """

    def pose(self) -> UncertainSensorPose:
        """Where the robot believes its lidar to be."""

    def take_scan(self) -> Scan:
        """One revolution as the driver gives it.

        Raises:
            DeviceError: no scan came.
        """


@runtime_checkable
class Arm(Protocol):
    """An arm with a gripper."""

    name: str

    def reachable(self) -> tuple[str, ...]:
        """The grasps that the arm can attempt now."""

    def attempt(self, grasp: str) -> GraspOutcome:
        """Attempt a grasp.

        Raises:
            UnknownName: there is no such grasp.
            DeviceError: the arm cannot even try.
        """


def device_of(reference: str) -> Any:
    """The device that a function makes, named as `package.module:function`.

    Raises:
        UnknownName: there is no such module or function.
    """
    module_name, _, function_name = reference.partition(":")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise UnknownName("module", module_name, ["any that Python can import"]) from error
    make = getattr(module, function_name, None)
    if not callable(make):
        known = sorted(name for name, value in vars(module).items() if callable(value) and not name.startswith("_"))
        raise UnknownName(f"function of {module_name}", function_name, known)
    return make()
