"""`voa evaluate drops`: how an object comes to rest, and the prior over its poses that follows.

Every pose of the scenario is confirmed by letting go of the object there; then it is dropped, turned at random.
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from voa_cli.evaluate.common import count, progress_bar
from voa_evaluation.resting import STABLE_RAD, Drops, drop, prior_of, tilt_when_let_go
from voa_fleet.errors import FleetError
from voa_fleet.world.objects import FleetObject, named_object


def main(arguments: Sequence[str] | None = None) -> int:
    """Drop, print; returns 0, or 1 if a pose is not stable or something is wrong."""
    options = _parser().parse_args(arguments)
    try:
        target = named_object(options.object)
        with progress_bar(f"dropping the {target.name}", options.drops) as advance:
            report = drop_report(target, drop(target, options.drops, options.seed, advance))
    except (FleetError, ValueError) as error:
        print(f"voa evaluate drops: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(report, sys.stdout, indent=1)
        print()
    else:
        _print(Console(), report)
    return 0 if all(pose["stable"] for pose in report["poses"]) else 1


def drop_report(target: FleetObject, drops: Drops) -> dict[str, Any]:
    """What `--json` prints."""
    tilts = [tilt_when_let_go(target, pose) for pose in target.poses]
    return {
        "object": target.name,
        "drops": drops.total,
        "seed": drops.seed,
        "rests": [{"name": name, "count": found} for name, found in drops.counts.items()],
        "poses": [
            {"name": pose, "prior": share, "tilt_deg": math.degrees(tilt), "stable": tilt < STABLE_RAD}
            for pose, share, tilt in zip(target.poses, prior_of(target, drops), tilts, strict=True)
        ],
    }


def _print(console: Console, report: dict[str, Any]) -> None:
    console.print(f"{report['drops']} drops of the {report['object']}", highlight=False)
    rests = Table("came to rest", Column("times", justify="right"))
    for rest in report["rests"]:
        rests.add_row(escape(rest["name"]), str(rest["count"]))
    figures = [Column(heading, justify="right") for heading in ("prior", "tilt when let go, degrees")]
    poses = Table("pose", *figures, "stable")
    for pose in report["poses"]:
        stable = "yes" if pose["stable"] else "[bold]NO[/bold]"
        poses.add_row(escape(pose["name"]), f"{pose['prior']:.3f}", f"{pose['tilt_deg']:.2f}", stable)
    console.print(rests)
    console.print(poses)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate drops", description=__doc__)
    parser.add_argument("object", nargs="?", default="mug", help="mug (default), mallet, block, or a folder")
    parser.add_argument("--drops", type=count, default=300, help="how many (default 300)")
    parser.add_argument("--seed", type=int, default=0, help="of the orientations (default 0)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
