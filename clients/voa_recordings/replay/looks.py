"""Replay of the robots' scans in a recording: looks and places are recognised in them as in live scans.

Each robot of a mapping receives its own topics in the order of the recording. Robots whose mapping names the same
session share one here as well, a new session on the scenario that is replayed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client import Client, ProblemError, VoaClientError
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, SessionRequest, UpdatedSession
from voa_msgs.warnings import ProbableMistake
from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.reading import Recording
from voa_recordings.limits import most_beams
from voa_recordings.replay.mappings import check_places
from voa_ros.grids import BeamGrid
from voa_ros.looks import GatheredLook, look_name
from voa_ros.pipeline import LookPipeline, Received, UnreadableMessage, UnusableMessage
from voa_ros.robots import RobotMapping
from voa_ros.topics import LASER_SCAN, MessageType, match_key


@dataclass(frozen=True)
class ReplayedLook:
    """A look of a recording, with the service's response, or with the reason why the service refused it."""

    robot: str
    request: ScanRequest
    response: UpdatedSession | None
    refused: str | None


@dataclass(frozen=True)
class ReplayedRobot:
    """Scans and looks of one robot in a recording.

    Attributes:
        robot: its name in the mapping.
        session: id of the session that received its looks.
        scans: number of its scans in the recording.
        looks: number of its looks that were sent.
        waiting_for: the condition for another look that was not met at the end; None: there is none.
        warnings: probable mistakes in how the robot was used.
        unreadable: why the newest message that could not be used was not; None: all could.
    """

    robot: str
    session: str
    scans: int
    looks: int
    waiting_for: str | None
    warnings: Sequence[ProbableMistake]
    unreadable: str | None


@dataclass(frozen=True)
class LooksReport:
    """Looks of a recording that were sent to a service.

    Attributes:
        scenario: that the sessions are on.
        robots: in the order of the mapping.
        looks: in the order of the recording.
        messages: number of messages that were read from the recording.
        damage: of the recording, as predicates ("ends in the middle"); None: none.
    """

    scenario: Scenario
    robots: Sequence[ReplayedRobot]
    looks: Sequence[ReplayedLook]
    messages: int
    damage: str | None


def replay_looks(
    client: Client, recording: Recording, scenario: Scenario, mappings: Sequence[RobotMapping]
) -> LooksReport:
    """Send the looks of a recording to new sessions on a scenario.

    Args:
        client: of the service.
        recording: with LaserScan topics.
        scenario: stored on the service.
        mappings: of the robots.

    Raises:
        InvalidMapping: a mapping does not fit the scenario.
        UnreadableRecording: the recording cannot be read, or has no scans of these robots; no session is left behind.
        VoaClientError: the service cannot be reached.
    """
    check_places(mappings, scenario)
    grid, most = _grid(scenario), most_beams()
    sessions: dict[str, str] = {}
    robots: list[_Robot] = []
    for mapping in mappings:
        target = mapping.session or mapping.scenario or ""
        if target not in sessions:
            sessions[target] = client.create_session(SessionRequest(scenario=scenario.id)).id
        robots.append(_Robot(mapping, sessions[target], LookPipeline(mapping, grid, most)))
    looks: list[ReplayedLook] = []
    try:
        _send_looks(client, recording, robots, looks)
    except UnreadableRecording:
        if not looks:
            for session in sessions.values():
                client.delete_session(session)
        raise
    reports = [robot.report(sum(look.robot == robot.name for look in looks)) for robot in robots]
    return LooksReport(scenario, reports, looks, recording.recovered, recording.damage)


class _Robot:
    """A robot of the mapping: the scans received so far, and its next look."""

    def __init__(self, mapping: RobotMapping, session: str, looks: LookPipeline) -> None:
        self.name = mapping.name
        self.topic = f"/{mapping.scan_topic}"
        self.session = session
        self.scans = 0
        self.unreadable: str | None = None
        self._mapping = mapping
        self._looks = looks
        self._accepted = 0

    def receive(self, message: RecordedMessage) -> GatheredLook | None:
        """Take a message of the recording if it is on one of the robot's topics; return the look that it completes."""
        type_ = self._type_of(message)
        if type_ is None:
            return None
        if message.type_name not in ("", type_.name) or message.encoding != "cdr":
            actual = f"{message.type_name or 'message of unknown type'} in {message.encoding or 'an unknown encoding'}"
            self.unreadable = f"{message.topic}: expected a {type_.name} in cdr, found a {actual}"
            return None
        try:
            taken = self._looks.receive(Received(type_, message.data, message.log_ns * 1e-9))
        except UnusableMessage as error:
            self.unreadable = f"{message.topic}: {error}"
            self.scans += type_ == LASER_SCAN and not isinstance(error, UnreadableMessage)
            return None
        self.scans += type_ == LASER_SCAN
        return taken if isinstance(taken, GatheredLook) else None

    def send(self, client: Client, taken: GatheredLook) -> ReplayedLook:
        """Send a look; if it is not accepted, the next revolutions of the same stop make another."""
        key = look_name(self.name, self.session, self._accepted + 1, taken)
        try:
            response = client.apply_scan(self.session, taken.request, key=key)
        except ProblemError as error:
            refused = f"{error.kind}: {error.problem.detail}"
            self._looks.rejected(refused)
            return ReplayedLook(self.name, taken.request, None, refused)
        if response.update.accepted:
            self._accepted += 1
        else:
            self._looks.rejected(response.update.reason or "not accepted")
        return ReplayedLook(self.name, taken.request, response, None)

    def report(self, looks: int) -> ReplayedRobot:
        """Sum up what was received, and `looks`, the number of looks that were sent."""
        return ReplayedRobot(
            robot=self.name,
            session=self.session,
            scans=self.scans,
            looks=looks,
            waiting_for=self._looks.waiting_for,
            warnings=self._looks.warnings,
            unreadable=self.unreadable,
        )

    def _type_of(self, message: RecordedMessage) -> MessageType | None:
        """Return the type of the mapped topic that a message is on; None: on none of them, or in another domain."""
        for subscription in self._mapping.subscriptions:
            key = message.key or message.topic.removeprefix("/")  # a key of rmw_zenoh has the domain in it
            if match_key(subscription.topic, key, self._mapping.domain) is not None:
                return subscription.type
        return None


def _send_looks(client: Client, recording: Recording, robots: Sequence[_Robot], looks: list[ReplayedLook]) -> None:
    """Append each look that was sent to `looks`; raises UnreadableRecording where no robot has a scan."""
    for message in recording.messages():
        for robot in robots:
            taken = robot.receive(message)
            if taken is not None:
                looks.append(robot.send(client, taken))
    if not any(robot.scans for robot in robots):
        topics = ", ".join(robot.topic for robot in robots)
        why = next((f"; {robot.unreadable}" for robot in robots if robot.unreadable is not None), "")
        raise UnreadableRecording(f"no {LASER_SCAN.name} on {topics}{recording.summary}{why}")


def _grid(scenario: Scenario) -> BeamGrid:
    """Return the beams of the scenario's lidar, which the service has filled in from its preset."""
    lidar = scenario.lidar
    if lidar.beams is None or lidar.angle_min is None or lidar.angle_increment is None:
        raise VoaClientError(
            "expected a scenario whose lidar has beams, angle_min and angle_increment, as this version of the service "
            "answers it: update the service"
        )
    return BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
