"""The scans of robots in a bag, through a service: looks and places are found as they are live.

Every robot of a mapping hears its own topics in the order of the recording. Robots that the mapping sends to one
session feed one here, new and on the scenario that is named.
"""

import argparse
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from voa_cli.recordings.mcap_file import RecordedMessage, UnreadableRecording
from voa_cli.recordings.reading import Recording
from voa_cli.recordings.ros_types import LASER_SCAN, ODOMETRY
from voa_cli.scenario_file import load_scenario
from voa_client import Client, ProblemError, VoaClientError
from voa_msgs.reading import in_one_line
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, SessionRequest, UpdatedSession
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.looks import LookTaker, Taken, Where
from voa_ros.places import NoPose, localisation, middle_s
from voa_ros.robots import AttachmentPlace, InvalidRobots, RobotMapping, SensorPlace, load

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


@dataclass
class Heard:
    """A robot, and what has come of its scans."""

    mapping: RobotMapping
    session: str
    scans: int = 0
    unreadable: str | None = None
    """Why, of the newest payload on a topic of this robot that could not be read."""

    def __post_init__(self) -> None:
        self._taker = LookTaker(self.mapping.name, self.mapping.look)
        self._localisation = localisation(self.mapping)

    @property
    def waiting_for(self) -> str | None:
        """What the next look would need."""
        return self._taker.waiting_for

    def hear(self, message: RecordedMessage) -> Taken | None:
        """Take a message in that may be this robot's; the look, if there is one now."""
        topic = message.topic.removeprefix("/")
        expected = next((each.type.name for each in self.mapping.subscriptions if each.topic == topic), None)
        if expected is None:
            return None
        if message.type_name not in ("", expected) or message.encoding != "cdr":
            found = f"{message.type_name or 'message of unknown type'} in {message.encoding or 'an unknown encoding'}"
            self.unreadable = f"{message.topic}: expected a {expected} in cdr, found a {found}"
            return None
        try:
            return self._heard(expected, message)
        except InvalidCdr as error:
            self.unreadable = f"{message.topic}: {error}"
        return None

    def _heard(self, type_name: str, message: RecordedMessage) -> Taken | None:
        if type_name == LASER_SCAN:
            return self._scan(message)
        if self._localisation is not None and type_name == ODOMETRY:
            self._localisation.hear_odometry(decode_odometry(message.data))
        elif self._localisation is not None:
            self._localisation.hear_amcl(decode_pose(message.data))
        return None

    def _scan(self, message: RecordedMessage) -> Taken | None:
        scan = decode_laser_scan(message.data)
        self.scans += 1
        where: Where | NoPose
        if self._localisation is not None:
            where = self._localisation.at(middle_s(scan, self.mapping.stamp))
        else:
            where = self.mapping.place.sensor if isinstance(self.mapping.place, SensorPlace) else NoPose("not told")
        taken = self._taker.heard(scan, where)
        return taken if isinstance(taken, Taken) else None


@dataclass(frozen=True)
class Found:
    """All that came of a recording."""

    scenario: Scenario
    robots: list[Heard]
    looks: list[Look] = field(default_factory=list)


def replay(client: Client, recording: Recording, options: argparse.Namespace) -> Found:
    """Send the looks of a recording to new sessions on a scenario.

    Args:
        client: of the service.
        recording: with LaserScan topics.
        options: `scenario`, and `robots`, or `sensor`, `topic` and `look`.

    Raises:
        InvalidMapping: the mapping or the sensor does not fit.
        UnreadableRecording: it cannot be read, or has no scans on these topics.
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
    robots = [Heard(mapping, sessions[mapping.session or mapping.scenario or ""]) for mapping in mappings]
    found = Found(scenario, robots)
    for message in recording.messages():
        for robot in robots:
            taken = robot.hear(message)
            if taken is not None:
                found.looks.append(_look(client, robot, taken))
    if not any(robot.scans for robot in robots):
        raise UnreadableRecording(_no_scans(robots, recording))
    return found


def _no_scans(robots: list[Heard], recording: Recording) -> str:
    topics = ", ".join(f"/{robot.mapping.scan_topic}" for robot in robots)
    why = next((f"; {robot.unreadable}" for robot in robots if robot.unreadable is not None), "")
    return f"no {LASER_SCAN} on {topics}{recording.found}{why}"


def _look(client: Client, robot: Heard, taken: Taken) -> Look:
    name = robot.mapping.name
    try:
        answer = client.apply_scan(robot.session, taken.request, key=taken.name)
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
    topics = sorted({message.topic for message in recording.messages() if message.type_name == LASER_SCAN})
    if len(topics) != 1:
        raise InvalidMapping(f"--topic: expected one topic with scans, name which{recording.found}")
    return topics[0]
