"""Protocols of a sensor robot and of an arm, simulated or real.

A real device may block for as long as it needs. It raises `DeviceError` where it cannot do what was requested.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from voa_fleet.errors import FleetError
from voa_msgs.geometry import SensorConfiguration, UncertainSensorPose
from voa_msgs.sessions import Scan


class DeviceError(FleetError):
    """A device cannot do what was requested of it; the message says why."""


@dataclass(frozen=True)
class GraspOutcome:
    """Outcome of an attempt of a grasp.

    Attributes:
        grasp: name of the grasp.
        success: True if the object was lifted.
        detail: end of the attempt, in words; "" where the device does not know.
        moved_m: distance by which the object has moved over the table, metres; None: it is not known.
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
        """Drive the lidar to a sensor configuration; return when the robot stands still there, as far as it knows.

        Raises:
            DeviceError: the robot cannot get there.
        """

    def pose(self) -> UncertainSensorPose:
        """Return the pose of the lidar as the robot estimates it, with its standard deviations where it knows them."""

    def take_scan(self) -> Scan:
        """Take a scan of one revolution, as the driver gives it.

        Raises:
            DeviceError: the lidar sends no scan.
        """


@runtime_checkable
class Arm(Protocol):
    """An arm with a gripper."""

    name: str

    def reachable(self) -> tuple[str, ...]:
        """Return the names of the grasps that the arm can attempt now."""

    def attempt(self, grasp: str) -> GraspOutcome:
        """Attempt a grasp and lift.

        Raises:
            UnknownName: there is no such grasp.
            DeviceError: the arm cannot even start the attempt.
        """
