"""`voa evaluate grasp-score`: how often each grasp succeeds at each pose, in simulation.

Writes into the output folder the table as picture and as CSV, and a scenario file that the service takes, with the
mesh beside it.
"""

import argparse
import csv
import json
import math
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from voa_fleet.commands.common import progress_bar
from voa_fleet.errors import FleetError
from voa_fleet.grasp_scores import RESULTS, GraspScores, score_grasps
from voa_fleet.imperfections import Imperfections
from voa_fleet.objects import FleetObject, named_object
from voa_fleet.pictures import grasp_score_table


def main(arguments: Sequence[str] | None = None) -> int:
    """Attempt, write, print; returns 0, or 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    try:
        thing = named_object(options.object)
        if options.opening_mm is not None:
            thing = thing.with_opening(options.opening_mm / 1e3)
        flaws = Imperfections(
            object_xy_m=options.noise_xy_mm / 1e3, object_yaw_rad=math.radians(options.noise_yaw_deg)
        )
        total = len(thing.poses) * len(thing.grasps) * options.attempts
        with progress_bar(f"attempting grasps of the {thing.name}", total) as advance:
            scores = score_grasps(
                thing, options.attempts, flaws, options.seed, processes=options.processes, progress=advance
            )
        files = write_scores(options.out, thing, scores)
    except (FleetError, OSError) as error:
        print(f"voa evaluate grasp-score: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(scores.report(), sys.stdout, indent=1)
        print()
        return 0
    console = Console()
    console.print(score_table(scores))
    for what, file in files.items():
        console.print(f"{what}: {file}", highlight=False, soft_wrap=True)
    return 0


def write_scores(folder: Path, thing: FleetObject, scores: GraspScores) -> dict[str, Path]:
    """Write picture, CSV, scenario and mesh; returns the files by what they are."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"grasp-score-{scores.object}"
    picture, table, scenario = (folder / f"{stem}.png", folder / f"{stem}.csv", folder / f"{scores.object}.json")
    grasp_score_table(picture, scores)
    write_csv(table, scores)
    request = scores.scenario(thing.scenario)
    scenario.write_text(request.model_dump_json(indent=1, exclude_none=True) + "\n", encoding="utf-8")
    mesh = str(thing.scenario.object)
    if (folder / mesh).resolve() != (thing.folder / mesh).resolve():
        shutil.copyfile(thing.folder / mesh, folder / mesh)
    return {"picture": picture, "table": table, "scenario": scenario}


def write_csv(file: Path, scores: GraspScores) -> None:
    """One row per cell: counts, share, 95 % interval, and how the attempts ended."""
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(["pose", "grasp", "successes", "attempts", "share", "low", "high", *RESULTS])
        for cell in (cell for row in scores.cells for cell in row):
            low, high = cell.interval
            counts = [cell.results.get(result, 0) for result in RESULTS]
            figures = [f"{number:.4f}" for number in (cell.successes / cell.attempts, low, high)]
            writer.writerow([cell.pose, cell.grasp, cell.successes, cell.attempts, *figures, *counts])


def score_table(scores: GraspScores) -> Table:
    """The table on a terminal; beside a cell that failed most of the time, why it did."""
    table = Table(title=f"Grasp score of the {scores.object}: successes of {scores.attempts}", title_justify="left")
    table.add_column("pose")
    for grasp in scores.grasps:
        table.add_column(grasp)
    for row in scores.cells:
        cells = []
        for cell in row:
            failures = [result for result in cell.results if result != "lifted"]
            worst = max(failures, key=lambda result: cell.results[result]) if failures else None
            why = f" [dim]{worst}[/dim]" if worst is not None and 2 * cell.successes < cell.attempts else ""
            cells.append(f"{cell.successes}{why}")
        table.add_row(row[0].pose, *cells)
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate grasp-score", description=__doc__)
    parser.add_argument("object", nargs="?", default="mug", help="mug (default), mallet, bracket, or a folder")
    parser.add_argument("--attempts", type=_count, default=15, help="per pose and grasp (default 15)")
    parser.add_argument("--noise-xy-mm", type=_amount, default=5.0, help="std of the object's place (default 5)")
    parser.add_argument("--noise-yaw-deg", type=_amount, default=3.0, help="std of its heading (default 3)")
    parser.add_argument("--opening-mm", type=_amount, help="of the gripper; default: the object's own setting")
    parser.add_argument("--seed", type=int, default=0, help="of the noise (default 0)")
    parser.add_argument("--processes", type=_count, default=1, help="that work at a time (default 1)")
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a number of at least 1, got {text}")
    return number


def _amount(text: str) -> float:
    number = float(text)
    if not (math.isfinite(number) and number >= 0.0):
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text}")
    return number
