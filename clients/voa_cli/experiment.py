"""`voa experiment`: begin a recorded experiment, check one, or make one from a recording of a robot.

voa experiment new DIR --scenario FILE      an empty experiment: fill in the column `measured` of DIR/scans.csv
voa experiment check DIR                    list what is missing or wrong; exit code 1 after errors
voa experiment from-recording BAG --scenario FILE --robots FILE --poses TABLE.csv -o DIR
                                            the looks of a rosbag2, MCAP or ROS 1 bag, with a table of the poses

The table says at which pose the object lay, one row per time or per look of the recording:

    pose,from,to            seconds since the recording began, or times of the day in ISO 8601
    upright 0,12.0,40.0
    upright 45,55.0,80.0

    pose,look               numbers as `voa replay BAG` lists the looks
    upright 0,1

With a column `sensor`, the lidar stood at that sensor configuration of the scenario, and --robots is not needed. The
results are read by `voa replay DIR` and `voa evaluate all --recorded DIR`.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from voa_cli.replay.sessions import show_damage
from voa_client import Client, Scenario, VoaClientError
from voa_client.local import service_at
from voa_client.message_files import read_file
from voa_client.scenario_files import InvalidScenarioFile, ScenarioFile, load_scenario
from voa_msgs.geometry import CandidateSensor, SensorConfiguration
from voa_msgs.scenarios import PredictionsRequest
from voa_recordings.experiment_check import ExperimentCheck, check_experiment
from voa_recordings.experiment_of_looks import AssignedLook, experiment_scans, looks_of, times_of
from voa_recordings.experiment_parts import ExperimentObject
from voa_recordings.experiment_writing import (
    Predicted,
    experiment_of_scenario,
    height_of,
    refuse_experiment,
    write_experiment,
)
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.pose_table import PoseRow, read_pose_table
from voa_recordings.replay.mappings import check_places, mapping_of_one_lidar, read_mappings
from voa_ros.robots import RobotMapping

_MOST_COLUMNS = 12
"""Number of poses up to which the table of scans has a column for each."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a part of the command and return its exit code; 1 after an error."""
    options = _parser().parse_args(arguments)
    try:
        code: int = options.run(options, Console(highlight=False))
    except VoaClientError as error:
        print(f"voa experiment: {error}", file=sys.stderr)
        return 1
    return code


def _new(options: argparse.Namespace, console: Console) -> int:
    refuse_experiment(options.folder)
    with service_at(options.url) as client:
        scenario = load_scenario(client, options.scenario)
        predicted = _predicted(client, scenario, scenario.sensors)
    mesh, object_ = _mesh(options.scenario, console)
    content = experiment_of_scenario(
        scenario, scenario.sensors, predicted, object_, options.selection, options.no_return
    )
    heights = {sensor.name: height_of(scenario, sensor) for sensor in scenario.sensors}
    write_experiment(options.folder, content, heights, predicted, {}, mesh)
    pairs = len(scenario.poses) * len(scenario.sensors)
    console.print(
        f"{options.folder}: an experiment with {len(scenario.poses)} poses and {len(scenario.sensors)} places, nothing "
        f"measured yet.\n\n"
        f"1. Put the object at a pose and the lidar at a place, and take one scan; {pairs} pairs in all. A place that "
        "lacks a pose gets no AECD.\n"
        f"2. Write the measured ranges, in metres, into the column `measured` of {options.folder / 'scans.csv'}: the "
        "rows of that sensor and pose, each beam at its angle_deg in the lidar's frame. Leave a no-return empty; add a "
        "row for a beam that has none. Or record a bag, and use: voa experiment from-recording.\n"
        f'3. experiment.json says that the rows are "{options.selection}"'
        + (" scans: keep every beam near the object, whether it fits or not" if options.selection == "whole" else "")
        + f"; beyond {content.observation.no_return:g} m a measured beam counts as a no-return.\n"
        f"4. voa experiment check {options.folder}; then: voa replay {options.folder}",
        markup=False,
        soft_wrap=True,
    )
    return 0


def _check(options: argparse.Namespace, console: Console) -> int:
    return _show_check(check_experiment(options.folder), options.folder, console)


def _from_recording(options: argparse.Namespace, console: Console) -> int:
    refuse_experiment(options.out)
    recording = Recording(options.recording, RosTypes())
    table = read_pose_table(options.poses, *times_of(recording))
    mappings = _mappings(options, recording, table)
    with service_at(options.url) as client:
        scenario = load_scenario(client, options.scenario)
        if options.robots is not None and not all(row.sensor for row in table):
            check_places(mappings, scenario)
        looks = list(looks_of(recording, scenario, mappings, table))
        scans = experiment_scans(looks, scenario)
        predicted = _predicted(client, scenario, scans.sensors)
    mesh, object_ = _mesh(options.scenario, console)
    content = experiment_of_scenario(scenario, scans.sensors, predicted, object_, "whole", options.no_return)
    heights = {sensor.name: height_of(scenario, sensor) for sensor in scans.sensors}
    write_experiment(options.out, content, heights, predicted, scans.measured, mesh)
    _show_looks(scans.looks, console)
    show_damage(console, recording.damage, recording.recovered)
    return _show_check(check_experiment(options.out), options.out, console)


def _mappings(options: argparse.Namespace, recording: Recording, table: Sequence[PoseRow]) -> Sequence[RobotMapping]:
    if options.robots is not None:
        return read_mappings(options.robots)
    named = [row.sensor for row in table if row.sensor is not None]
    if len(named) < len(table):
        raise VoaClientError(
            f"{options.poses}: expected the option --robots, or a column `sensor` with the lidar's place in every row"
        )
    return [mapping_of_one_lidar(recording, named[0], options.topic, "stationary")]


def _predicted(client: Client, scenario: Scenario, sensors: Sequence[SensorConfiguration]) -> Predicted:
    """Let the service predict the scans from sensor configurations, listed in the scenario or not."""
    listed = {sensor.name for sensor in scenario.sensors}
    candidates = [
        sensor.name
        if sensor.name in listed
        else CandidateSensor(name=sensor.name, x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m)
        for sensor in sensors
    ]
    predictions = client.predict(scenario.id, PredictionsRequest(sensors=candidates))
    return {
        (sensor, pose): ranges
        for sensor, of_sensor in zip(predictions.sensors, predictions.ranges, strict=True)
        for pose, ranges in zip(predictions.poses, of_sensor, strict=True)
    }


def _mesh(scenario: Path, console: Console) -> tuple[Path | None, ExperimentObject | None]:
    """Return the mesh file of a scenario file and its entry in the experiment; None where there is none to copy."""
    file = read_file(ScenarioFile, scenario, InvalidScenarioFile)
    mesh = None if file.object is None else scenario.parent / file.object
    if mesh is None or not mesh.is_file():
        return None, None
    if file.up == "+Y" or mesh.suffix.lower() in (".glb", ".gltf"):
        console.print(
            f"{mesh.name} is left out, because the mesh of a recorded experiment has z up; predictions are in it",
            markup=False,
        )
        return None, None
    return mesh, ExperimentObject(mesh=mesh.name, scale=1.0 if file.scale is None else file.scale)


def _show_looks(looks: Sequence[AssignedLook], console: Console) -> None:
    table = Table("look", "time", "robot", "pose", "place", "off", "missing", title="Looks", title_justify="left")
    for each in looks:
        row = each.look.row
        pose = "" if row is None else row.pose
        off = f"{1e3 * each.off_m:.0f} mm {math.degrees(each.off_rad):.1f}°" if each.unused is None else ""
        place = each.sensor or "" if each.unused is None else f"not used: {each.unused}"
        missing = str(each.missing) if each.unused is None else ""
        cells = (str(each.look.number), f"{each.look.at_s:.1f} s", each.look.robot, pose, place, off, missing)
        table.add_row(*map(escape, cells))
    console.print(table)
    lost = sum(each.missing for each in looks)
    if lost:
        console.print(
            f"{lost} beams are missing (lost, or hidden by something in front of the workspace): scans.csv cannot "
            "state that, and they count as no-returns",
            soft_wrap=True,
        )


def _show_check(check: ExperimentCheck, folder: Path, console: Console) -> int:
    for remark in check.remarks:
        console.print(f"{'ERROR' if remark.severity == 'error' else '!'} {remark.text}", markup=False, soft_wrap=True)
    if check.name is not None:
        _show_counts(check, console)
    warnings = len(check.remarks) - check.errors
    counts = f"{check.errors} error{'s' * (check.errors != 1)}, {warnings} warning{'s' * (warnings != 1)}"
    verdict = counts if check.remarks else "nothing looks wrong"
    console.print(f"{folder}: {verdict}", style="bold", markup=False, soft_wrap=True)
    if not check.errors:
        console.print(f"now: voa replay {folder}; voa evaluate all --recorded {folder}", markup=False, soft_wrap=True)
    return 1 if check.errors else 0


def _show_counts(check: ExperimentCheck, console: Console) -> None:
    """Print how many scans there are of each pose from each place, with the number of measured beams."""
    total = len(check.measured)
    console.print(f"{total} of {len(check.sensors) * len(check.poses)} scans measured", markup=False)
    if len(check.poses) > _MOST_COLUMNS:
        for sensor in check.sensors:
            own = sum(pair[0] == sensor for pair in check.measured)
            console.print(f"  {sensor}: {own} of {len(check.poses)} poses", markup=False)
        return
    table = Table("place", *map(escape, check.poses), title="Measured beams of each scan", title_justify="left")
    for sensor in check.sensors:
        table.add_row(escape(sensor), *(str(check.beams[sensor, pose] or "-") for pose in check.poses))
    console.print(table)


def _positive(text: str) -> float:
    value = math.nan
    with suppress(ValueError):
        value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a distance in metres above 0, got {text!r}")
    return value


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="voa experiment", description=__doc__, formatter_class=raw)
    parts = parser.add_subparsers(metavar="PART", required=True)
    new = parts.add_parser("new", help="write an empty experiment for a scenario")
    new.add_argument("folder", type=Path, metavar="DIR", help="folder to be written")
    new.add_argument(
        "--selection",
        choices=["whole", "matched"],
        default="whole",
        help="rows that scans.csv will have: whole scans (default), or beams matched with the true pose's prediction",
    )
    new.set_defaults(run=_new)
    check = parts.add_parser("check", help="list what is missing or wrong in an experiment")
    check.add_argument("folder", type=Path, metavar="DIR", help="folder with experiment.json and scans.csv")
    check.set_defaults(run=_check)
    bag = parts.add_parser("from-recording", help="make an experiment from a rosbag2, MCAP or ROS 1 bag")
    bag.add_argument("recording", type=Path, metavar="BAG", help="rosbag2 folder, MCAP file or ROS 1 bag")
    bag.add_argument("--poses", type=Path, required=True, metavar="TABLE.csv", help="at which pose the object lay")
    bag.add_argument("--robots", type=Path, metavar="FILE", help="mapping of robots, the file of `voa serve --robots`")
    bag.add_argument("--topic", help="without --robots: topic of the scans (default: the only topic that has scans)")
    bag.add_argument("-o", "--out", type=Path, required=True, metavar="DIR", help="folder to be written")
    bag.set_defaults(run=_from_recording)
    for part in (new, bag):
        part.add_argument("--scenario", type=Path, required=True, metavar="FILE", help="scenario file")
        part.add_argument(
            "--no-return",
            type=_positive,
            metavar="METRES",
            help="range from which on a beam is a no-return (default: the scenario's, or 5 cm behind all predictions)",
        )
        part.add_argument(
            "--url", help="address of a running service (default: start one for the length of the command)"
        )
    return parser
