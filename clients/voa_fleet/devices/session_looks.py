"""Looks of one robot, and how they reach a session: through the client here, by ROS 2 in `ros2`."""

from dataclasses import dataclass
from typing import Protocol

from voa_client import Client
from voa_fleet.devices.looking import REVOLUTIONS, median_look
from voa_fleet.devices.protocol import SensorRobot
from voa_fleet.world.lidar import LidarGeometry, lidar_geometry
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, Session, SessionRequest, UpdateReport


@dataclass(frozen=True)
class TakenLook:
    """A look that the session has.

    Attributes:
        sensor: where the robot was sent.
        request: what the service was told; None where that is not known.
        after: the session then.
        update: what the look did to it; None: it was not accepted, and nobody says why.
    """

    sensor: str
    request: ScanRequest | None
    after: Session
    update: UpdateReport | None


class Looking(Protocol):
    """How a look gets from the robot to the session."""

    def open(self, scenario: Scenario) -> Session:
        """Open the session that the looks from now on are for."""

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """Look from where the robot stands, until the session has it or has refused it."""


@dataclass(frozen=True, eq=False)
class ByClient:
    """Looks that go through the client, as scans of the contract.

    A robot that states how well it knows its pose sends that pose along; one that states nothing stands at the
    configuration that it was sent to.

    Attributes:
        client: of the service.
        robot: that looks.
        lidar: its beams.
        revolutions: in one look.
    """

    client: Client
    robot: SensorRobot
    lidar: LidarGeometry
    revolutions: int = REVOLUTIONS

    def open(self, scenario: Scenario) -> Session:
        """Open a session that claims no robot: its looks are sent to it by its id.

        Raises:
            VoaClientError: the service refuses it, or does not answer.
        """
        return self.client.create_session(SessionRequest(scenario=scenario.id))

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """The median of some revolutions, and where they were taken.

        Raises:
            VoaClientError: the service refuses it, or does not answer.
            DeviceError: no scan came.
        """
        scan = median_look([self.robot.take_scan() for _ in range(self.revolutions)], self.lidar)
        pose = self.robot.pose()
        request = (
            ScanRequest(sensor=sensor.name, scan=scan) if pose.std is None else ScanRequest(sensor_pose=pose, scan=scan)
        )
        after = self.client.apply_scan(session.id, request)
        return TakenLook(sensor.name, request, after, after.update)


def looking_by(client: Client, robot: SensorRobot, scenario: Scenario, revolutions: int = REVOLUTIONS) -> ByClient:
    """Looks through the client, with the beams that the scenario states.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    return ByClient(client, robot, lidar_geometry(scenario.lidar), revolutions)
