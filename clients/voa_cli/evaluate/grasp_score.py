"""`voa evaluate grasp-score`: measure in simulation how often each grasp succeeds at each pose.

Writes into the output folder the scores as picture and as CSV, and a scenario file for the service, with the mesh
beside it.
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
from rich.markup import escape
from rich.table import Table

from voa_cli.evaluate.common import add_objects, amount, count, objects_of, progress_bar
from voa_cli.evaluate.documents import grasp_score_document, one_or_all
from voa_evaluation.grasp_scores import GraspScores, score_grasps
from voa_evaluation.report.figures import grasp_score_table
from voa_fleet.errors import FleetError
from voa_fleet.world.attempts import Result
from voa_fleet.world.cells import RESULTS, Cell
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the files and print; return 0, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    console = Console()
    documents = []
    try:
        for target in objects_of(options):
            scores = _score(target, options)
            files = write_scores(options.out, target, scores)
            documents.append(grasp_score_document(scores))
            if not options.json:
                _show(console, scores, files)
    except (FleetError, OSError) as error:
        print(f"voa evaluate grasp-score: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(one_or_all(documents), sys.stdout, indent=1)
        print()
    return 0


def _score(target: FleetObject, options: argparse.Namespace) -> GraspScores:
    if options.opening_mm is not None:
        target = target.with_opening(options.opening_mm / 1e3)
    imperfections = Imperfections(
        object_xy_m=options.noise_xy_mm / 1e3, object_yaw_rad=math.radians(options.noise_yaw_deg)
    )
    total = len(target.poses) * len(target.grasps) * options.attempts
    with progress_bar(f"attempting grasps of the {target.name}", total) as advance:
        return score_grasps(
            target, options.attempts, imperfections, options.seed, processes=options.processes, progress=advance
        )


def _show(console: Console, scores: GraspScores, files: dict[str, Path]) -> None:
    console.print(f"Grasp score of the {scores.object}: successes of {scores.attempts} attempts", highlight=False)
    console.print(score_table(scores))
    console.print(failure_legend(scores), highlight=False)
    for contents, file in files.items():
        console.print(f"{contents}: {file}", highlight=False, soft_wrap=True)


def write_scores(folder: Path, target: FleetObject, scores: GraspScores) -> dict[str, Path]:
    """Write picture, CSV, scenario and mesh; return their paths by a description of their contents."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"grasp-score-{scores.object}"
    picture, table, scenario = (folder / f"{stem}.png", folder / f"{stem}.csv", folder / f"{scores.object}.json")
    grasp_score_table(picture, scores)
    write_csv(table, scores)
    request = scores.scenario(target.scenario)
    scenario.write_text(request.model_dump_json(indent=1, exclude_none=True) + "\n", encoding="utf-8")
    mesh = str(target.scenario.object)
    if (folder / mesh).resolve() != (target.folder / mesh).resolve():
        shutil.copyfile(target.folder / mesh, folder / mesh)
    return {"picture": picture, "table": table, "scenario": scenario}


def write_csv(file: Path, scores: GraspScores) -> None:
    """Write a row per cell: counts, share, 95 % interval, and the results of the attempts."""
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(["pose", "grasp", "successes", "attempts", "share", "low", "high", *RESULTS])
        for cell in (cell for row in scores.cells for cell in row):
            low, high = cell.interval
            counts = [cell.results.get(result, 0) for result in RESULTS]
            figures = [f"{number:.4f}" for number in (cell.successes / cell.attempts, low, high)]
            writer.writerow([cell.pose, cell.grasp, cell.successes, cell.attempts, *figures, *counts])


_LETTERS: dict[Result, str] = {
    "out of reach": "r",
    "in the way": "w",
    "stopped on approach": "s",
    "nothing between the fingers": "n",
    "not held": "h",
    "slipped": "l",
}


def score_table(scores: GraspScores) -> Table:
    """Make the table for a terminal; a letter in a cell with mostly failures names the most frequent one."""
    table = Table()
    table.add_column("pose")
    for grasp in scores.grasps:
        table.add_column(escape(grasp), justify="right")
    for row in scores.cells:
        failures = [_most_frequent_failure(cell) for cell in row]
        letters = [" " if failure is None else _LETTERS[failure] for failure in failures]
        cells = [f"{cell.successes} [dim]{letter}[/dim]" for cell, letter in zip(row, letters, strict=True)]
        table.add_row(escape(row[0].pose), *cells)
    return table


def failure_legend(scores: GraspScores) -> str:
    """Explain the letters that occur in the table."""
    failures = [_most_frequent_failure(cell) for row in scores.cells for cell in row]
    return ", ".join(f"{letter} {result}" for result, letter in _LETTERS.items() if result in failures)


def _most_frequent_failure(cell: Cell) -> Result | None:
    failures = {result: count for result, count in cell.results.items() if result != "lifted"}
    if 2 * cell.successes >= cell.attempts or not failures:
        return None
    return max(failures, key=lambda result: failures[result])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate grasp-score", description=__doc__)
    add_objects(parser)
    parser.add_argument("--attempts", type=count, default=15, help="attempts per pose and grasp (default 15)")
    parser.add_argument(
        "--noise-xy-mm", type=amount, default=5.0, help="standard deviation of the object's place (default 5)"
    )
    parser.add_argument(
        "--noise-yaw-deg", type=amount, default=3.0, help="standard deviation of its heading (default 3)"
    )
    parser.add_argument("--opening-mm", type=amount, help="opening of the gripper; default: the object's own setting")
    parser.add_argument("--seed", type=int, default=0, help="seed of the noise (default 0)")
    parser.add_argument("--processes", type=count, default=1, help="number of processes (default 1)")
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
