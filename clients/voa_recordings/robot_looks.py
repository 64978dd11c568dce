"""Looks of one robot in a recording: its topics are picked out, and its scans become looks as they do live."""

from collections.abc import Sequence

from voa_client import VoaClientError
from voa_msgs.scenarios import Scenario
from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.reading import Recording
from voa_ros.grids import BeamGrid
from voa_ros.looks import GatheredLook
from voa_ros.pipeline import LookPipeline, Received, UnreadableMessage, UnusableMessage
from voa_ros.robots import RobotMapping
from voa_ros.topics import LASER_SCAN, MessageType, match_key


class RobotLooks:
    """Scans that were received of a robot of a mapping, and its next look.

    Attributes:
        name: of the robot in the mapping.
        topic: of its scans.
        scans: number of its scans so far.
        unreadable: why the newest message that could not be used was not; None: all could.
        pipeline: from its messages to looks.
    """

    def __init__(self, mapping: RobotMapping, grid: BeamGrid, most_beams: int) -> None:
        self.name = mapping.name
        self.topic = f"/{mapping.scan_topic}"
        self.scans = 0
        self.unreadable: str | None = None
        self.pipeline = LookPipeline(mapping, grid, most_beams)
        self._mapping = mapping

    def receive(self, message: RecordedMessage) -> GatheredLook | None:
        """Take a message of the recording if it is on one of the robot's topics; return the look that it completes."""
        type_ = self.type_of(message)
        if type_ is None:
            return None
        if message.type_name not in ("", type_.name) or message.encoding != "cdr":
            actual = f"{message.type_name or 'message of unknown type'} in {message.encoding or 'an unknown encoding'}"
            self.unreadable = f"{message.topic}: expected a {type_.name} in cdr, found a {actual}"
            return None
        try:
            taken = self.pipeline.receive(Received(type_, message.data, message.log_ns * 1e-9))
        except UnusableMessage as error:
            self.unreadable = f"{message.topic}: {error}"
            self.scans += type_ == LASER_SCAN and not isinstance(error, UnreadableMessage)
            return None
        self.scans += type_ == LASER_SCAN
        return taken if isinstance(taken, GatheredLook) else None

    def type_of(self, message: RecordedMessage) -> MessageType | None:
        """Return the type of the mapped topic that a message is on; None: on none of them, or in another domain."""
        for subscription in self._mapping.subscriptions:
            key = message.key or message.topic.removeprefix("/")  # a key of rmw_zenoh has the domain in it
            if match_key(subscription.topic, key, self._mapping.domain) is not None:
                return subscription.type
        return None


def raise_without_scans(robots: Sequence[RobotLooks], recording: Recording) -> None:
    """Raise UnreadableRecording if a recording that was read to its end has no scan of these robots."""
    if not any(robot.scans for robot in robots):
        topics = ", ".join(robot.topic for robot in robots)
        why = next((f"; {robot.unreadable}" for robot in robots if robot.unreadable is not None), "")
        raise UnreadableRecording(f"no {LASER_SCAN.name} on {topics}{recording.summary}{why}")


def grid_of(scenario: Scenario) -> BeamGrid:
    """Return the beams of the scenario's lidar, which the service has filled in from its preset."""
    lidar = scenario.lidar
    if lidar.beams is None or lidar.angle_min is None or lidar.angle_increment is None:
        raise VoaClientError(
            "expected a scenario whose lidar has beams, angle_min and angle_increment, as this version of the service "
            "answers it: update the service"
        )
    return BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
