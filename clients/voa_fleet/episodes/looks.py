"""Looks of one robot, and the way on which they reach a session: here through the client, in `ros2_looks` by ROS 2."""

from dataclasses import dataclass
from typing import Protocol

from voa_client import Client
from voa_fleet.devices.protocol import SensorRobot
from voa_fleet.episodes.look_scans import REVOLUTIONS, median_look
from voa_fleet.world.lidar import LidarGeometry, lidar_geometry
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, Session, SessionRequest, UpdateReport


@dataclass(frozen=True)
class EpisodeLook:
    """A look of an episode, after it has reached the session.

    Attributes:
        sensor: name of the sensor configuration to which the robot was sent.
        request: the scan as the service received it; None where that is not known.
        after: the session after the look.
        update: the service's report on the update; None: the look was not accepted, and no reason is known.
    """

    sensor: str
    request: ScanRequest | None
    after: Session
    update: UpdateReport | None


class LookChannel(Protocol):
    """Way of looks from a robot to a session."""

    def open(self, scenario: Scenario) -> Session:
        """Open the session that receives the looks from now on."""

    def look(self, session: Session, sensor: SensorConfiguration) -> EpisodeLook:
        """Look from where the robot stands; return when the session has accepted or refused the look."""


@dataclass(frozen=True, eq=False)
class ClientChannel:
    """Looks that are sent through the client.

    A robot that states standard deviations of its pose sends that pose along; one that states none is taken to stand
    at the sensor configuration to which it was sent.

    Attributes:
        client: of the service.
        robot: takes the scans.
        lidar: its beams.
        revolutions: in one look.
    """

    client: Client
    robot: SensorRobot
    lidar: LidarGeometry
    revolutions: int = REVOLUTIONS

    def open(self, scenario: Scenario) -> Session:
        """Open a session that claims no robot.

        Raises:
            VoaClientError: the service refuses it, or does not answer.
        """
        return self.client.create_session(SessionRequest(scenario=scenario.id))

    def look(self, session: Session, sensor: SensorConfiguration) -> EpisodeLook:
        """Send the median of some revolutions, and where they were taken.

        Raises:
            VoaClientError: the service refuses it, or does not answer.
            DeviceError: the lidar sends no scan.
        """
        scan = median_look([self.robot.take_scan() for _ in range(self.revolutions)], self.lidar)
        pose = self.robot.pose()
        request = (
            ScanRequest(sensor=sensor.name, scan=scan) if pose.std is None else ScanRequest(sensor_pose=pose, scan=scan)
        )
        after = self.client.apply_scan(session.id, request)
        return EpisodeLook(sensor.name, request, after, after.update)


def client_channel(
    client: Client, robot: SensorRobot, scenario: Scenario, revolutions: int = REVOLUTIONS
) -> ClientChannel:
    """Make the channel of a robot through the client, with the beams that the scenario states.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    return ClientChannel(client, robot, lidar_geometry(scenario.lidar), revolutions)
