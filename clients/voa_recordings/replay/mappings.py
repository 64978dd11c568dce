"""Mappings of the robots in a recording: whose topics are whose, where the lidar stood, and which scans are looks."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import ValidationError

from voa_client import VoaClientError
from voa_msgs.reading import in_one_line
from voa_msgs.scenarios import Scenario
from voa_recordings.files.reading import Recording
from voa_ros.robot_places import AttachmentPlace, SensorPlace
from voa_ros.robots import InvalidRobots, RobotMapping, load
from voa_ros.topics import LASER_SCAN

_SESSION = "replay"


class InvalidMapping(VoaClientError):
    """A mapping of robots cannot be used for a recording; the message says which part, and what was expected."""


def read_mappings(path: Path) -> Sequence[RobotMapping]:
    """Read the mappings of a `robots.toml` file.

    A recording has nobody who requests looks: robots that look on request take a look at each stop instead.

    Raises:
        InvalidMapping: the file cannot be read, is no mapping, or maps no robot.
    """
    try:
        mappings = load(path.read_text(encoding="utf-8"))
    except (InvalidRobots, OSError, UnicodeDecodeError) as error:
        raise InvalidMapping(f"{path}: {error}") from error
    if not mappings:
        raise InvalidMapping(f"{path} maps no robot: expected at least one [[robot]]")
    return tuple(_without_requests(mapping) for mapping in mappings)


def mapping_of_one_lidar(
    recording: Recording, sensor: str, topic: str | None, mode: Literal["stationary", "every"]
) -> RobotMapping:
    """Map the only lidar of a recording, which stood at one sensor configuration all the time.

    Args:
        recording: with a topic of LaserScan messages.
        sensor: name of the sensor configuration.
        topic: of the scans; None: the only topic that has any.
        mode: `stationary` takes a look of ten revolutions, `every` takes every scan as a look.

    Raises:
        InvalidMapping: several topics have scans or none has, or the topic or sensor is no valid name.
        UnreadableRecording: the recording cannot be read.
    """
    fields = {
        "name": "lidar",
        "namespace": "",
        "session": _SESSION,
        "scan": f"/{(topic or _only_topic(recording)).strip('/')}",
        "look": {"mode": mode},
        "place": {"from": "sensor", "sensor": sensor},
    }
    try:
        return RobotMapping.model_validate(fields)
    except ValidationError as error:
        raise InvalidMapping(f"--topic or --sensor: {in_one_line(RobotMapping, error)}") from error


def check_places(mappings: Sequence[RobotMapping], scenario: Scenario) -> None:
    """Raise InvalidMapping if a lidar's place comes from an attachment or a sensor that the scenario does not have."""
    known = [sensor.name for sensor in scenario.sensors]
    for mapping in mappings:
        if isinstance(mapping.place, AttachmentPlace):
            raise InvalidMapping(
                f"robot {mapping.name!r}: place.from: recordings have no attachments; expected sensor, odometry or amcl"
            )
        if isinstance(mapping.place, SensorPlace) and mapping.place.sensor not in known:
            raise InvalidMapping(
                f"robot {mapping.name!r}: the scenario has no sensor configuration {mapping.place.sensor!r}; it has "
                f"{', '.join(known)}"
            )


def _without_requests(mapping: RobotMapping) -> RobotMapping:
    if mapping.look.mode != "on_request":
        return mapping
    return mapping.model_copy(update={"look": mapping.look.model_copy(update={"mode": "stationary"})})


def _only_topic(recording: Recording) -> str:
    """Name the topic that has scans; raises InvalidMapping where there are several, or none."""
    topics = sorted({message.topic for message in recording.messages() if message.type_name == LASER_SCAN.name})
    if len(topics) != 1:
        raise InvalidMapping(
            f"--topic: expected exactly one topic with scans, and {len(topics)} have some; say which{recording.summary}"
        )
    return topics[0]
