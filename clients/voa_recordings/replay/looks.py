"""The scans of robots in a bag, through a service: looks and places are found as they are live.

Every robot of a mapping receives its own topics in the order of the recording. Robots that the mapping sends to one
session feed one here, new and on the scenario that is named.
"""

import argparse
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from voa_client import Client, ProblemError, VoaClientError
from voa_client.scenario_files import load_scenario
from voa_msgs.reading import in_one_line
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, SessionRequest, UpdatedSession
from voa_msgs.warnings import ProbableMistake
from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.reading import Recording
from voa_recordings.limits import most_beams
from voa_ros.grids import BeamGrid
from voa_ros.looks import GatheredLook, look_name
from voa_ros.pipeline import LookPipeline, Received, UnreadableMessage, UnusableMessage
from voa_ros.robot_places import AttachmentPlace, SensorPlace
from voa_ros.robots import InvalidRobots, RobotMapping, load
from voa_ros.topics import LASER_SCAN, MessageType, match_key

_OF_ITS_OWN = "replay"


class InvalidMapping(VoaClientError):
    """What was said of robots, topics or places cannot be used here."""


@dataclass(frozen=True)
class Look:
    """A look of the recording, and what the service made of it; `refused` where it took no notice."""

    robot: str
    request: ScanRequest
    answer: UpdatedSession | None
    refused: str | None


class Replayed:
    """A robot of the mapping, and what has come of its scans.

    Attributes:
        mapping: as the mapping says.
        session: that its looks go to.
        scans: received on its topic.
        unreadable: why the newest message on one of its topics could not be used; None: all could.
    """

    def __init__(self, mapping: RobotMapping, session: str, scenario: Scenario, most: int) -> None:
        self.mapping = mapping
        self.session = session
        self.scans = 0
        self.unreadable: str | None = None
        self._looks = LookPipeline(mapping, _grid(scenario), most)
        self._accepted = 0

    @property
    def waiting_for(self) -> str | None:
        """Condition for the next look that is not met yet."""
        return self._looks.waiting_for

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Probable mistakes in how the robot is used."""
        return self._looks.warnings

    def receive(self, message: RecordedMessage) -> GatheredLook | None:
        """Take a message that may be this robot's; returns a look if there is one now."""
        type_ = self._type_of(message)
        if type_ is None:
            return None
        if message.type_name not in ("", type_.name) or message.encoding != "cdr":
            found = f"{message.type_name or 'message of unknown type'} in {message.encoding or 'an unknown encoding'}"
            self.unreadable = f"{message.topic}: expected a {type_.name} in cdr, found a {found}"
            return None
        try:
            taken = self._looks.receive(Received(type_, message.data, message.log_ns * 1e-9))
        except UnusableMessage as error:
            self.unreadable = f"{message.topic}: {error}"
            self.scans += type_ == LASER_SCAN and not isinstance(error, UnreadableMessage)
            return None
        self.scans += type_ == LASER_SCAN
        return taken if isinstance(taken, GatheredLook) else None

    def _type_of(self, message: RecordedMessage) -> MessageType | None:
        """The type of the mapped topic that a message is on; None: it is on none, or of another domain."""
        for subscription in self.mapping.subscriptions:
            key = message.key or message.topic.removeprefix("/")  # of rmw_zenoh, with the domain, where it was kept
            if match_key(subscription.topic, key, self.mapping.domain) is not None:
                return subscription.type
        return None

    def answered(self, look: Look) -> None:
        """Note what became of a look: one that was not accepted does not use up the stop."""
        if look.answer is None:
            self._looks.rejected(look.refused or "refused")
        elif not look.answer.update.accepted:
            self._looks.rejected(look.answer.update.reason or "not accepted")
        else:
            self._accepted += 1

    def name(self, taken: GatheredLook) -> str:
        """Name of its next look."""
        return look_name(self.mapping.name, self.session, self._accepted + 1, taken)


@dataclass(frozen=True)
class Found:
    """All that came of a recording."""

    scenario: Scenario
    robots: list[Replayed]
    looks: list[Look] = field(default_factory=list)


def replay(client: Client, recording: Recording, options: argparse.Namespace) -> Found:
    """Send the looks of a recording to new sessions on a scenario.

    Args:
        client: of the service.
        recording: with LaserScan topics.
        options: `scenario`, and `robots`, or `sensor`, `topic` and `look`.

    Raises:
        InvalidMapping: the mapping or the sensor does not fit.
        UnreadableRecording: it cannot be read, or has no scans on these topics; no session stays behind.
        VoaClientError: the service cannot be reached, or refuses the scenario.
    """
    path = Path(options.scenario)
    scenario = load_scenario(client, path) if path.is_file() else client.get_scenario(options.scenario)
    mappings = _mappings(options, scenario, recording)
    sessions: dict[str, str] = {}
    for mapping in mappings:
        target = mapping.session or mapping.scenario or ""
        if target not in sessions:
            sessions[target] = client.create_session(SessionRequest(scenario=scenario.id)).id
    most = most_beams()
    robots = [
        Replayed(mapping, sessions[mapping.session or mapping.scenario or ""], scenario, most) for mapping in mappings
    ]
    found = Found(scenario, robots)
    try:
        _replay_into(found, client, recording)
    except UnreadableRecording:
        if not found.looks:
            for session in sessions.values():
                client.delete_session(session)
        raise
    return found


def _replay_into(found: Found, client: Client, recording: Recording) -> None:
    """Send all looks; raises UnreadableRecording where nothing can be read or no robot has a scan."""
    for message in recording.messages():
        for robot in found.robots:
            taken = robot.receive(message)
            if taken is not None:
                look = _look(client, robot, taken)
                robot.answered(look)
                found.looks.append(look)
    if not any(robot.scans for robot in found.robots):
        raise UnreadableRecording(_no_scans(found.robots, recording))


def _grid(scenario: Scenario) -> BeamGrid:
    """Beams of the scenario's lidar, which a service answers with its preset filled in."""
    lidar = scenario.lidar
    if lidar.beams is None or lidar.angle_min is None or lidar.angle_increment is None:
        raise VoaClientError("expected a scenario whose lidar has its beams filled in: is the service of this version?")
    return BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)


def _no_scans(robots: list[Replayed], recording: Recording) -> str:
    topics = ", ".join(f"/{robot.mapping.scan_topic}" for robot in robots)
    why = next((f"; {robot.unreadable}" for robot in robots if robot.unreadable is not None), "")
    return f"no {LASER_SCAN.name} on {topics}{recording.found}{why}"


def _look(client: Client, robot: Replayed, taken: GatheredLook) -> Look:
    name = robot.mapping.name
    try:
        answer = client.apply_scan(robot.session, taken.request, key=robot.name(taken))
    except ProblemError as error:
        return Look(name, taken.request, None, f"{error.kind}: {error.problem.detail}")
    return Look(name, taken.request, answer, None)


def _mappings(options: argparse.Namespace, scenario: Scenario, recording: Recording) -> tuple[RobotMapping, ...]:
    """The robots, fit for a recording: there is nobody to request a look, nor an attachment."""
    try:
        mappings = (
            load(options.robots.read_text(encoding="utf-8")) if options.robots else (_simple(options, recording),)
        )
    except InvalidRobots as error:
        raise InvalidMapping(f"{options.robots}: {error}") from error
    except ValidationError as error:
        raise InvalidMapping(f"--topic or --sensor: {in_one_line(RobotMapping, error)}") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidMapping(f"{options.robots}: {error}") from error
    if not mappings:
        raise InvalidMapping(f"{options.robots} maps no robot")
    known = [sensor.name for sensor in scenario.sensors]
    for mapping in mappings:
        if isinstance(mapping.place, AttachmentPlace):
            raise InvalidMapping(
                f"robot {mapping.name!r}: place.from: bags have no attachments; expected sensor, odometry or amcl"
            )
        if isinstance(mapping.place, SensorPlace) and mapping.place.sensor not in known:
            raise InvalidMapping(
                f"robot {mapping.name!r}: the scenario has no sensor configuration {mapping.place.sensor!r}; it has "
                f"{', '.join(known)}"
            )
    return tuple(_without_requests(mapping) for mapping in mappings)


def _without_requests(mapping: RobotMapping) -> RobotMapping:
    if mapping.look.mode != "on_request":
        return mapping
    return mapping.model_copy(update={"look": mapping.look.model_copy(update={"mode": "stationary"})})


def _simple(options: argparse.Namespace, recording: Recording) -> RobotMapping:
    told: dict[str, Any] = {
        "name": "lidar",
        "namespace": "",
        "session": _OF_ITS_OWN,
        "scan": f"/{(options.topic or _only_topic(recording)).strip('/')}",
        "look": {"mode": options.look},
        "place": {"from": "sensor", "sensor": options.sensor},
    }
    return RobotMapping.model_validate(told)


def _only_topic(recording: Recording) -> str:
    """The topic that has scans; raises InvalidMapping where there are several, or none."""
    topics = sorted({message.topic for message in recording.messages() if message.type_name == LASER_SCAN.name})
    if len(topics) != 1:
        raise InvalidMapping(f"--topic: expected one topic with scans, name which{recording.found}")
    return topics[0]
