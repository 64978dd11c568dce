"""`voa replay PATH`: what was recorded, through a service once more.

voa replay DIR                                   a recorded experiment (experiment.json, scans.csv)
voa replay session.json                          a session file (voa sessions export), made anew
voa replay look.mcap                             the sessions of a recording (voa record), each made anew
voa replay BAG --scenario FILE --robots lab.toml      a bag of ROS 2 or ROS 1, or an MCAP file: its looks, as live
voa replay BAG --scenario FILE --sensor ENE      the same, with the lidar at one of the scenario's places

An experiment gives, for every update rule and sensor configuration, the Value of Assistance beforehand, what the
look was worth with the scans that were really measured (AECD), and how far measurement and prediction are apart.
Sessions that are made anew must believe exactly what was recorded. Recordings are read in the order of their log
times; those that are damaged, as far as they go; compressed ones, too (zstd, gzip, bzip2, xz).
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from voa_cli.replay import looks_report
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_msgs.updates import BUILT_IN
from voa_recordings.experiment import read_experiment
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.reading import Recording, is_recording
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.files.sessions import recorded_sessions
from voa_recordings.replay import experiments, looks, recordings, session_files
from voa_recordings.replay.figures import distance_from_expected

_AGREES = 1e-6


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, print, and return 0; 1 if something is wrong or what was expected does not come out."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if (options.robots is None) == (options.sensor is None) and (options.scenario or options.sensor):
        parser.error("--scenario goes with either --robots FILE or --sensor NAME")
    if options.scenario is None and (options.robots or options.sensor):
        parser.error("--robots and --sensor need the --scenario that is looked at")
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
    with service_at(options.url) as client, _progress() as progress:
        report = experiments.replay(client, experiment, options.predict, rules, progress)
    if options.json:
        _print_json(report)
        return 0
    experiments.show(console, report)
    if experiment.expected is None or options.predict != "recorded":
        return 0
    apart = distance_from_expected(report, experiment.expected, experiment.pose_names)
    agrees = apart <= _AGREES
    console.print(f"expected.json: {'agrees' if agrees else 'DISAGREES'}, largest difference {apart:.1e}")
    return 0 if agrees else 1


def _replay_session(options: argparse.Namespace, console: Console) -> int:
    with service_at(options.url) as client:
        done = session_files.replay_file(client, options.path, options.mesh)
    if options.json:
        print(done.session.model_dump_json(indent=1))
    else:
        session_files.show(console, done)
    return 0 if done.same else 1


def _replay_recording(options: argparse.Namespace, console: Console) -> int:
    recording = Recording(options.path, RosTypes())
    sessions = recorded_sessions(recording.messages())
    if not sessions:
        raise UnreadableRecording(
            f"{options.path} holds no session{recording.found}; to replay the scans of a robot, name --scenario, and "
            "--robots or --sensor"
        )
    with service_at(options.url) as client:
        found = recordings.replay_sessions(client, sessions, options.mesh)
    if options.json:
        _print_json(recordings.report(found, recording))
    else:
        recordings.show(console, found, recording)
    return recordings.code_of(found)


def _replay_looks(options: argparse.Namespace, console: Console) -> int:
    recording = Recording(options.path, RosTypes())
    with service_at(options.url) as client:
        found = looks.replay(client, recording, options)
    if options.json:
        _print_json(looks_report.report(found, recording))
    else:
        looks_report.show(console, found, recording)
    return 0


def _print_json(report: dict[str, Any]) -> None:
    json.dump(report, sys.stdout, indent=1)
    print()


def _progress() -> Progress:
    """On a terminal; quiet in a pipe."""
    console = Console(stderr=True)
    return Progress(console=console, transient=True, disable=not console.is_terminal)


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
    parser.add_argument("path", type=Path, help="a recorded experiment, session file, recording or bag")
    parser.add_argument("--mesh", type=Path, help="of a session: the object's mesh, where the service lacks it")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")
    experiment = parser.add_argument_group("recorded experiments")
    experiment.add_argument(
        "--predict", choices=["recorded", "mesh"], default="recorded", help="where predictions are from"
    )
    experiment.add_argument(
        "--rules",
        nargs="+",
        metavar="NAME[,NAME]",
        type=_names,
        default=[list(experiments.RULES)],
        help=f"update rules, built in ({', '.join(BUILT_IN)}) or installed in the service by another package "
        f"(default {','.join(experiments.RULES)})",
    )
    bag = parser.add_argument_group("scans of robots, in a bag or recording")
    bag.add_argument("--scenario", help="what is looked at: a scenario file, or the id of a stored one")
    bag.add_argument("--robots", type=Path, help="which topics are whose, and where the lidars were (voa serve's file)")
    bag.add_argument("--sensor", help="instead: all scans were taken from this sensor configuration")
    bag.add_argument("--topic", help="with --sensor: where the scans are (default: the only topic that has any)")
    bag.add_argument(
        "--look",
        choices=["stationary", "every"],
        default="stationary",
        help="with --sensor: ten revolutions of a lidar at rest are one look (default), or every scan is one",
    )
    return parser
