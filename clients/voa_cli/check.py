"""`voa check`: list the probable mistakes in a scenario file, before a robot uses it.

voa check scenario.json                             exit code 0: no warning; 1: warnings; 2: it cannot be used
voa check scenario.json --url http://lab:8000       by a running service, which stores the scenario: prints its id

All pairs of a pose and a sensor configuration are checked. Warnings do not change what the service computes.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from voa_cli.warnings import print_warnings
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_client.scenario_files import load_with_warnings
from voa_msgs.warnings import Warnings


def main(arguments: Sequence[str] | None = None) -> int:
    """Check a scenario file, print the warnings, and return 0 for none, 1 for some, 2 if it cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        with service_at(options.url) as client:
            scenario, of_mesh = load_with_warnings(client, options.scenario)
            mistakes = [*of_mesh, *client.warnings(scenario.id).items]
    except VoaClientError as error:
        print(f"voa check: {error}", file=sys.stderr)
        return 2
    if options.json:
        print(Warnings(items=mistakes).model_dump_json(indent=1, exclude_none=True))
        return 1 if mistakes else 0
    console = Console(markup=False, highlight=False)
    print_warnings(console, mistakes)
    counts = f"{len(scenario.poses)} poses, {len(scenario.grasps)} grasps, {len(scenario.sensors)} places"
    console.print(f"{scenario.name!r} ({counts}): {_summary(len(mistakes))}", style="bold")
    if options.url is not None:
        console.print(f"stored as scenario {scenario.id}", soft_wrap=True)
    return 1 if mistakes else 0


def _summary(count: int) -> str:
    if count == 0:
        return "nothing looks wrong"
    return f"{count} warning{'s' * (count > 1)}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa check", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scenario", type=Path, help="scenario file, or a folder with scenario.json")
    parser.add_argument("--url", help="address of a running service (default: start one for the length of the command)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
