"""`voa replay PATH`: what was recorded, through a service once more.

A recorded experiment (a folder with experiment.json): for every update rule and sensor configuration the Value of
Assistance beforehand, what the look was worth with the scans that were really measured (AECD), and how far
measurement and prediction are apart. A session file (voa sessions export): the session, made anew.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from voa_cli.local_service import service_at
from voa_cli.replay import experiments, session_files
from voa_cli.replay.figures import distance_from_expected
from voa_client import VoaClientError
from voa_client.recorded import read_experiment

_AGREES = 1e-6


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, print, and return 0; 1 if something is wrong or what was expected does not come out."""
    options = _parser().parse_args(arguments)
    replay = _replay_session if options.path.is_file() else _replay_experiment
    try:
        return replay(options, Console())
    except VoaClientError as error:
        print(f"voa replay: {error}", file=sys.stderr)
        return 1


def _replay_experiment(options: argparse.Namespace, console: Console) -> int:
    experiment = read_experiment(options.path)
    with service_at(options.url) as client, _progress() as progress:
        report = experiments.replay(client, experiment, options.predict, options.rules, progress)
    if options.json:
        json.dump(report, sys.stdout, indent=1)
        print()
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


def _progress() -> Progress:
    """On a terminal; quiet in a pipe."""
    console = Console(stderr=True)
    return Progress(console=console, transient=True, disable=not console.is_terminal)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa replay", description=(__doc__ or "").partition("\n\n")[2])
    parser.add_argument("path", type=Path, help="folder of a recorded experiment, or a session file")
    parser.add_argument("--mesh", type=Path, help="of a session file: the object's mesh, where the service lacks it")
    parser.add_argument(
        "--predict", choices=["recorded", "mesh"], default="recorded", help="where predictions are from"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")
    parser.add_argument(
        "--rules",
        nargs="+",
        choices=[*experiments.RULES, "beam"],
        default=list(experiments.RULES),
        help=f"update rules (default {' '.join(experiments.RULES)})",
    )
    return parser
