"""Recorded experiments from recordings of robots, with a table that states at which pose the object lay."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from voa_client import VoaClientError
from voa_msgs.geometry import SensorConfiguration, SensorPose
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest
from voa_recordings.experiment_writing import Pair
from voa_recordings.files.reading import Recording
from voa_recordings.limits import most_beams
from voa_recordings.measured_beams import MeasuredBeams, measured_beams
from voa_recordings.pose_table import PoseRow
from voa_recordings.robot_looks import RobotLooks, grid_of, raise_without_scans
from voa_ros.motions import wrapped
from voa_ros.robots import RobotMapping
from voa_ros.topics import LASER_SCAN

NEAR_M = 0.05
"""Largest distance from a listed sensor configuration, metres, at which a look counts as taken from there."""
NEAR_RAD = math.radians(5.0)
"""Largest difference of yaw from a listed sensor configuration, radians, at which a look counts as taken from there."""


@dataclass(frozen=True)
class TimedLook:
    """A look of a recording.

    Attributes:
        number: from 1, in the order of the recording.
        at_s: time of its last revolution, seconds since the recording began.
        robot: name in the mapping.
        request: place and scan.
        row: of the table, which states the pose; None: no row does.
    """

    number: int
    at_s: float
    robot: str
    request: ScanRequest
    row: PoseRow | None


@dataclass(frozen=True)
class AssignedLook:
    """A look that was assigned to a pose and a sensor configuration, or the reason why it was not.

    Attributes:
        look: of the recording.
        sensor: name of the sensor configuration; None: not assigned.
        off_m, off_rad: distance of the lidar from that configuration, metres and radians.
        missing: number of its beams that say nothing.
        unused: reason why the look is not in the experiment; None: it is.
    """

    look: TimedLook
    sensor: str | None
    off_m: float
    off_rad: float
    missing: int
    unused: str | None


@dataclass
class ExperimentScans:
    """Scans for a recorded experiment.

    Attributes:
        sensors: sensor configurations from which looks were taken, those of the scenario first.
        measured: ranges by sensor configuration and pose.
        looks: all looks of the recording, in its order.
    """

    sensors: list[SensorConfiguration]
    measured: dict[Pair, Sequence[float | None]] = field(default_factory=dict)
    looks: list[AssignedLook] = field(default_factory=list)


def times_of(recording: Recording) -> tuple[int, int]:
    """Return the times of the first and last message of a recording, nanoseconds since 1970; raises if it has none."""
    times = [message.log_ns for message in recording.messages()]
    if not times:
        raise VoaClientError(f"the recording holds no message{recording.summary}")
    return times[0], times[-1]


def looks_of(
    recording: Recording, scenario: Scenario, mappings: Sequence[RobotMapping], table: Sequence[PoseRow]
) -> Iterator[TimedLook]:
    """Take the looks of a recording, each with the row of a table that states the object's pose.

    With a table of times, scans outside of its rows are not used, and each row begins a new stop: the object was moved,
    even where the robot stood still. With a table of looks, all looks are taken as in a live session.

    Raises:
        UnreadableRecording: the recording cannot be read, or has no scans of these robots.
    """
    grid, most = grid_of(scenario), most_beams()
    robots = [RobotLooks(mapping, grid, most) for mapping in mappings]
    by_time = any(row.from_ns is not None for row in table)
    by_look = {row.look: row for row in table}
    number, begin_ns, row = 0, None, None
    for message in recording.messages():
        begin_ns = message.log_ns if begin_ns is None else begin_ns
        if by_time and row is not (row := _row_at(table, message.log_ns)):
            for robot in robots:
                robot.pipeline.restart()
        for robot in robots:
            if by_time and (row is None or not row.pose) and robot.type_of(message) == LASER_SCAN:
                robot.scans += 1
                continue
            taken = robot.receive(message)
            if taken is not None:
                number += 1
                stated = row if by_time else by_look.get(number)
                yield TimedLook(number, (message.log_ns - begin_ns) * 1e-9, robot.name, taken.request, stated)
    raise_without_scans(robots, recording)


def _row_at(table: Sequence[PoseRow], at_ns: int) -> PoseRow | None:
    return next((row for row in table if (row.from_ns or 0) <= at_ns <= (row.to_ns or 0)), None)


def experiment_scans(looks: Sequence[TimedLook], scenario: Scenario) -> ExperimentScans:
    """Assign looks to the poses and sensor configurations of an experiment.

    A look within 5 cm and 5 degrees of a sensor configuration of the scenario counts as taken from there; others make
    a sensor configuration of their own, "place 1", "place 2", .... Of several looks at one pose from one sensor
    configuration the last is used.

    Raises:
        VoaClientError: no look can be used; the message says why.
    """
    places = {sensor.name: sensor for sensor in scenario.sensors}
    used: dict[Pair, tuple[int, MeasuredBeams]] = {}
    assigned: list[AssignedLook] = []
    for look in looks:
        problem = _problem(look, scenario)
        if problem is not None or look.row is None:
            assigned.append(AssignedLook(look, None, 0.0, 0.0, 0, problem))
            continue
        stated = look.row.sensor or look.request.sensor
        pose: SensorPose = places[stated] if stated is not None else _pose_of(look.request)
        sensor = places[stated] if stated is not None else _near(places, pose)
        places.setdefault(sensor.name, sensor)
        beams = measured_beams(look.request.scan, grid_of(scenario), scenario.lidar, pose, scenario.workspace)
        pair = sensor.name, look.row.pose
        if pair in used:
            before = used[pair][0]
            reason = f"look {look.number} is of the same pose and place, and the last counts"
            assigned[before] = AssignedLook(assigned[before].look, sensor.name, 0.0, 0.0, 0, reason)
        used[pair] = (len(assigned), beams)
        off = math.hypot(pose.x - sensor.x, pose.y - sensor.y), abs(wrapped(pose.yaw_rad - sensor.yaw_rad))
        assigned.append(AssignedLook(look, sensor.name, *off, beams.missing, None))
    if not used:
        raise VoaClientError(_nothing_used(assigned))
    with_looks = [sensor for sensor in places.values() if any(pair[0] == sensor.name for pair in used)]
    return ExperimentScans(with_looks, {pair: beams.ranges for pair, (_, beams) in used.items()}, assigned)


def _nothing_used(assigned: Sequence[AssignedLook]) -> str:
    if not assigned:
        return (
            "the recording has no look in the times of the table: check the times, and that the robot stands still for "
            "as many revolutions as the mapping's look.scans"
        )
    return f"none of the {len(assigned)} looks can be used: {assigned[0].unused}"


def _problem(look: TimedLook, scenario: Scenario) -> str | None:
    """Return the reason why a look cannot be used, in words; None: it can."""
    poses, sensors = [pose.name for pose in scenario.poses], [sensor.name for sensor in scenario.sensors]
    if look.row is None or not look.row.pose:
        return "the table states no pose for it"
    if look.row.pose not in poses:
        return f"line {look.row.line} of the table: the scenario has no pose {look.row.pose!r}, only {', '.join(poses)}"
    named = look.row.sensor or look.request.sensor
    if named is not None and named not in sensors:
        return f"the scenario has no sensor configuration {named!r}, only {', '.join(sensors)}"
    return None


def _pose_of(request: ScanRequest) -> SensorPose:
    pose = request.sensor_pose
    if pose is None:
        raise VoaClientError("expected a look with a sensor configuration or a sensor pose")
    return pose


def _near(places: Mapping[str, SensorConfiguration], pose: SensorPose) -> SensorConfiguration:
    """Return the sensor configuration at a pose of the lidar, or a new one."""
    for sensor in sorted(places.values(), key=lambda each: math.hypot(pose.x - each.x, pose.y - each.y)):
        near = math.hypot(pose.x - sensor.x, pose.y - sensor.y) <= NEAR_M
        if near and abs(wrapped(pose.yaw_rad - sensor.yaw_rad)) <= NEAR_RAD:
            return sensor
    name = next(name for number in range(1, len(places) + 2) if (name := f"place {number}") not in places)
    return SensorConfiguration(name=name, x=pose.x, y=pose.y, yaw_rad=pose.yaw_rad, height_m=pose.height_m)
