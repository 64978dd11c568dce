"""`voa evaluate drops`: drop an object many times, and derive the prior over its poses from how it comes to rest.

First the stability of every pose of the scenario is checked, by releasing the object there; then the object is dropped,
turned at random.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from voa_cli.evaluate.common import count, progress_bar
from voa_cli.evaluate.documents import rest_document
from voa_evaluation.resting import drop_repeatedly, tilt_when_let_go
from voa_fleet.errors import FleetError
from voa_fleet.world.objects import named_object


def main(arguments: Sequence[str] | None = None) -> int:
    """Drop the object and print the counts; return 0, or 1 if a pose is not stable or an error was reported."""
    options = _parser().parse_args(arguments)
    try:
        target = named_object(options.object)
        with progress_bar(f"dropping the {target.name}", options.drops) as advance:
            rests = drop_repeatedly(target, options.drops, options.seed, advance)
        document = rest_document(target, rests, [tilt_when_let_go(target, pose) for pose in target.poses])
    except (FleetError, ValueError) as error:
        print(f"voa evaluate drops: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(document, sys.stdout, indent=1)
        print()
    else:
        _print(Console(), document)
    return 0 if all(pose["stable"] for pose in document["poses"]) else 1


def _print(console: Console, document: dict[str, Any]) -> None:
    console.print(f"{document['drops']} drops of the {document['object']}", highlight=False)
    rests = Table("came to rest", Column("times", justify="right"))
    for rest in document["rests"]:
        rests.add_row(escape(rest["name"]), str(rest["count"]))
    figures = [Column(heading, justify="right") for heading in ("prior", "tilt after release, degrees")]
    poses = Table("pose", *figures, "stable")
    for pose in document["poses"]:
        stable = "yes" if pose["stable"] else "[bold]NO[/bold]"
        poses.add_row(escape(pose["name"]), f"{pose['prior']:.3f}", f"{pose['tilt_deg']:.2f}", stable)
    console.print(rests)
    console.print(poses)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate drops", description=__doc__)
    parser.add_argument(
        "object", nargs="?", default="mug", help="mug (default), mallet, block, goblet, coupling, or a folder"
    )
    parser.add_argument("--drops", type=count, default=300, help="number of drops (default 300)")
    parser.add_argument("--seed", type=int, default=0, help="of the orientations (default 0)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
