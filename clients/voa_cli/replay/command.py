"""`voa replay PATH`: send what was recorded through a service again.

voa replay DIR                                    a recorded experiment (experiment.json, scans.csv)
voa replay session.json                           a session file (voa sessions export): the session is rebuilt
voa replay look.mcap                              a recording (voa record): each of its sessions is rebuilt
voa replay BAG --scenario FILE --robots lab.toml  a ROS 2 or ROS 1 bag or MCAP file: its scans make looks, as live
voa replay BAG --scenario FILE --sensor ENE       the same, with the lidar at one sensor configuration all the time

A recorded experiment gives, for every update rule and sensor configuration, the Value of Assistance before the look,
the value of the look with the scans that were measured (AECD), and the differences between measured and predicted
ranges; and says how its rows were chosen. A rebuilt session must have exactly the recorded belief. Messages of
recordings are read in the order of their log times; of damaged recordings, those that can be read. Compressed files are
unpacked (zstd, gzip, bzip2, xz).
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from voa_cli.progress import shown_progress
from voa_cli.replay import experiments, looks, sessions
from voa_client import Client, Scenario, VoaClientError
from voa_client.local import service_at
from voa_client.scenario_files import load_scenario
from voa_msgs.updates import BUILT_IN, PAPER_RULES
from voa_recordings.experiment import read_experiment
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.reading import Recording, is_recording
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.files.sessions import recorded_sessions
from voa_recordings.replay.experiment_report import distance_from_expected
from voa_recordings.replay.experiments import replay_experiment
from voa_recordings.replay.looks import replay_looks
from voa_recordings.replay.mappings import mapping_of_one_lidar, read_mappings
from voa_recordings.replay.sessions import SessionsReport, replay_sessions
from voa_recordings.session_file import read_session_file, rebuild_session

_TOLERANCE = 1e-6


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, print the results, and return 0; 1 after an error, or if the results are not the expected ones."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if (options.robots is None) == (options.sensor is None) and (options.scenario or options.sensor):
        parser.error("--scenario needs exactly one of --robots FILE and --sensor NAME")
    if options.scenario is None and (options.robots or options.sensor):
        parser.error("--robots and --sensor need --scenario, the scenario that the robots looked at")
    try:
        return _replay(options, Console())
    except VoaClientError as error:
        print(f"voa replay: {error}", file=sys.stderr)
        return 1


def _replay(options: argparse.Namespace, console: Console) -> int:
    if options.scenario is not None:
        return _replay_looks(options, console)
    if is_recording(options.path):
        return _replay_recording(options, console)
    if options.path.is_file():
        return _replay_session(options, console)
    return _replay_experiment(options, console)


def _replay_experiment(options: argparse.Namespace, console: Console) -> int:
    experiment = read_experiment(options.path)
    rules = [rule for names in options.rules for rule in names]
    with service_at(options.url) as client, shown_progress("replaying") as progress:
        report = replay_experiment(client, experiment, options.predict, rules, progress)
    if options.json:
        _print_json(report.document())
        return 0
    experiments.show(console, report)
    if experiment.expected is None or options.predict != "recorded":
        return 0
    distance = distance_from_expected(report, experiment.expected)
    agrees = distance <= _TOLERANCE
    console.print(f"expected.json: {'agrees' if agrees else 'DISAGREES'}, largest difference {distance:.1e}")
    return 0 if agrees else 1


def _replay_session(options: argparse.Namespace, console: Console) -> int:
    file = read_session_file(options.path)
    with service_at(options.url) as client:
        rebuilt = rebuild_session(client, file, options.mesh)
    if options.json:
        print(rebuilt.session.model_dump_json(indent=1))
    else:
        sessions.show_one(console, rebuilt)
    return 0 if rebuilt.same else 1


def _replay_recording(options: argparse.Namespace, console: Console) -> int:
    recording = Recording(options.path, RosTypes())
    recorded = recorded_sessions(recording.messages())
    if not recorded:
        raise UnreadableRecording(
            f"{options.path} holds no session{recording.summary}; to replay the scans of a robot, give --scenario, and "
            "--robots or --sensor"
        )
    with service_at(options.url) as client:
        replays = replay_sessions(client, recorded, options.mesh)
    report = SessionsReport(recording.recovered, recording.damage, replays)
    if options.json:
        _print_json(sessions.document(report))
    else:
        sessions.show(console, report)
    return 0 if report.agrees else 1


def _replay_looks(options: argparse.Namespace, console: Console) -> int:
    recording = Recording(options.path, RosTypes())
    with service_at(options.url) as client:
        scenario = _scenario(client, options.scenario)
        if options.robots is not None:
            mappings = read_mappings(options.robots)
        else:
            mappings = [mapping_of_one_lidar(recording, options.sensor, options.topic, options.look)]
        report = replay_looks(client, recording, scenario, mappings)
    if options.json:
        _print_json(looks.document(report))
    else:
        looks.show(console, report)
    return 0


def _scenario(client: Client, text: str) -> Scenario:
    """Load a scenario file, or get the stored scenario of an id."""
    path = Path(text)
    return load_scenario(client, path) if path.is_file() else client.get_scenario(text)


def _print_json(document: dict[str, Any]) -> None:
    json.dump(document, sys.stdout, indent=1)
    print()


def _names(text: str) -> list[str]:
    """Split names at commas; raises ValueError where one is empty."""
    names = text.split(",")
    if not all(names):
        raise ValueError(text)
    return names


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa replay",
        description=(__doc__ or "").partition("\n\n")[2],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("path", type=Path, help="a recorded experiment, a session file, a recording or a bag")
    parser.add_argument(
        "--mesh", type=Path, help="for sessions: the mesh file of their object, if the service does not have it"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--url", help="address of a running service (default: start one for the length of the command)")
    experiment = parser.add_argument_group("recorded experiments")
    experiment.add_argument(
        "--predict",
        choices=["recorded", "mesh"],
        default="recorded",
        help="predictions of scans.csv (default), or computed from the mesh",
    )
    experiment.add_argument(
        "--rules",
        nargs="+",
        metavar="NAME[,NAME]",
        type=_names,
        default=[list(PAPER_RULES)],
        help=f"update rules, built in ({', '.join(BUILT_IN)}) or provided to the service by another package "
        f"(default {','.join(PAPER_RULES)})",
    )
    bag = parser.add_argument_group("scans of robots, in a bag or recording")
    bag.add_argument(
        "--scenario", help="the scenario that the robots looked at: a file, or the id of a stored scenario"
    )
    bag.add_argument(
        "--robots", type=Path, help="mapping of topics to robots and places, the file of `voa serve --robots`"
    )
    bag.add_argument("--sensor", help="instead of --robots: the sensor configuration from which all scans were taken")
    bag.add_argument("--topic", help="with --sensor: topic of the scans (default: the only topic that has scans)")
    bag.add_argument(
        "--look",
        choices=["stationary", "every"],
        default="stationary",
        help="with --sensor: a look is ten revolutions of a lidar at rest (default), or every scan",
    )
    return parser
