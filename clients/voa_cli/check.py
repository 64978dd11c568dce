"""`voa check`: what is probably wrong with a scenario file, before a robot finds out.

voa check scenario.json                             exit code 0: nothing; 1: warnings; 2: it cannot be used
voa check scenario.json --url http://lab:8000       by a running service, which keeps the scenario

Every pair of pose and place is looked at. A warning never changes what the service computes.
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
    """Check a scenario file, print what was found, and return 0, 1 for warnings, or 2 if it cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        with service_at(options.url) as client:
            scenario, of_mesh = load_with_warnings(client, options.scenario)
            found = [*of_mesh, *client.warnings(scenario.id).items]
    except VoaClientError as error:
        print(f"voa check: {error}", file=sys.stderr)
        return 2
    if options.json:
        print(Warnings(items=found).model_dump_json(indent=1, exclude_none=True))
        return 1 if found else 0
    console = Console(markup=False, highlight=False)
    print_warnings(console, found)
    counts = f"{len(scenario.poses)} poses, {len(scenario.grasps)} grasps, {len(scenario.sensors)} places"
    console.print(f"{scenario.name!r} ({counts}): {_summary(len(found))}", style="bold")
    return 1 if found else 0


def _summary(count: int) -> str:
    if count == 0:
        return "nothing looks wrong"
    return f"{count} warning{'s' * (count > 1)}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa check", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scenario", type=Path, help="scenario file; its `object` may be a mesh beside it")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
