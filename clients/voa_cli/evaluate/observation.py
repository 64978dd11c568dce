"""`voa evaluate observation`: compare measured scans with predicted ones.

The measured scans come from the simulated lidar or from a recorded experiment. Writes into the output folder the
differences per beam and per sensor configuration as CSV, and two pictures: the differences, and the scans drawn over
each other.
"""

import argparse
import csv
import json
import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from voa_cli.evaluate.common import add_objects, amount, count, objects_of, progress_bar
from voa_cli.evaluate.documents import observation_document, one_or_all
from voa_client import VoaClientError
from voa_evaluation.observation import (
    Errors,
    ObservationErrors,
    Source,
    has_predictions,
    recorded_errors,
    simulated_errors,
)
from voa_evaluation.report.figures import errors_by_beam, scan_overlays
from voa_fleet.errors import FleetError
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject
from voa_recordings.experiment import RecordedExperiment, read_experiment
from voa_recordings.selection import describe_selection


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, write the files and print; return 0, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    console = Console()
    documents = []
    try:
        for errors in _compared(options, console):
            files = write_errors(options.out, errors)
            documents.append(observation_document(errors))
            if not options.json:
                _show(console, errors, files)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa evaluate observation: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(one_or_all(documents), sys.stdout, indent=1)
        print()
    return 0


def _compared(options: argparse.Namespace, console: Console) -> Iterator[ObservationErrors]:
    if options.recorded is not None:
        experiment = read_experiment(options.recorded)
        yield errors_of_record(experiment, options.predict)
        if not options.json:
            console.print(describe_selection(experiment.selection), markup=False, highlight=False)
        return
    for target in objects_of(options):
        yield _simulated(target, options)


def _show(console: Console, errors: ObservationErrors, files: dict[str, Path]) -> None:
    console.print(error_table(errors))
    overall = errors.overall
    if overall.beams:
        console.print(
            f"{overall.beams} beams of {errors.scans} scans return in both: median |measured - predicted| "
            f"{overall.median_abs:.1f} mm, 95 % below {overall.p95_abs:.1f} mm",
            highlight=False,
        )
    for contents, file in files.items():
        console.print(f"{contents}: {file}", highlight=False, soft_wrap=True)


def errors_of_record(experiment: RecordedExperiment, source: Source | None = None) -> ObservationErrors:
    """Compare a recorded experiment with its own predictions, or with its mesh if it has none.

    Args:
        experiment: the recorded experiment.
        source: of the predictions; None: its own, if it has any.

    Raises:
        InvalidExperiment: the experiment lacks what predictions from the mesh need.
    """
    return recorded_errors(experiment, source or ("recorded" if has_predictions(experiment) else "mesh"))


def _simulated(target: FleetObject, options: argparse.Namespace) -> ObservationErrors:
    imperfections = replace(
        Imperfections.of_lds_01(),
        robot_xy_m=options.robot_xy_mm / 1e3,
        robot_yaw_rad=math.radians(options.robot_yaw_deg),
        range_noise_m=options.range_noise_mm / 1e3,
        object_xy_m=options.noise_xy_mm / 1e3,
        object_yaw_rad=math.radians(options.noise_yaw_deg),
    )
    total = options.scans * len(target.poses) * len(target.scenario.sensors)
    with progress_bar(f"scans of the {target.name}", total) as advance:
        return simulated_errors(target, options.scans, imperfections, options.seed, advance)


def write_errors(folder: Path, compared: ObservationErrors) -> dict[str, Path]:
    """Write tables and pictures; return their paths by a description of their contents."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"observation-{file_name(compared.name)}"
    files = {
        "per beam": folder / f"{stem}-beams.csv",
        "per sensor configuration": folder / f"{stem}-sensors.csv",
        "picture of the differences": folder / f"{stem}-errors.png",
        "picture of the scans": folder / f"{stem}-scans.png",
    }
    beams, sensors, differences, scans = files.values()
    by_beam = [((sensor, f"{angle:g}"), errors) for (sensor, angle), errors in compared.by_beam().items()]
    _write_csv(beams, ("sensor", "angle_deg"), by_beam)
    by_sensor = [((sensor,), errors) for sensor, errors in compared.by_sensor().items()]
    _write_csv(sensors, ("sensor",), [*by_sensor, (("all",), compared.overall)])
    errors_by_beam(differences, compared)
    scan_overlays(scans, compared)
    return files


def file_name(name: str) -> str:
    """Replace the characters of an experiment's name that a file system may refuse."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip("-.") or "experiment"


def _write_csv(file: Path, keys: tuple[str, ...], rows: Sequence[tuple[tuple[str, ...], Errors]]) -> None:
    """Write statistics in millimetres; the columns that count beams have no unit."""
    counted = {"beams", "only_measured", "only_predicted"}
    names = [field.name if field.name in counted else f"{field.name}_mm" for field in fields(Errors)]
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow([*keys, *names])
        for key, errors in rows:
            writer.writerow([*key, *(_figure(value) for value in asdict(errors).values())])


def _figure(value: float | None) -> str:
    if value is None:
        return ""
    return str(value) if isinstance(value, int) else f"{value:.3f}"


def error_table(compared: ObservationErrors) -> Table:
    """Make the table of statistics per sensor configuration for a terminal."""
    table = Table(
        title=f"{escape(compared.name)}: measured minus predicted, mm",
        title_justify="left",
        caption="|d|: median size; m, p: beams that return in the measured or in the predicted scan alone",
        caption_justify="left",
    )
    for heading in ("sensor", "beams", "mean", "median", "std", "min", "max", "|d|", "m", "p"):
        table.add_column(heading, justify="left" if heading == "sensor" else "right")
    for sensor, errors in {**compared.by_sensor(), "all": compared.overall}.items():
        figures = (errors.mean, errors.median, errors.std, errors.lowest, errors.highest, errors.median_abs)
        cells = ["-" if figure is None else f"{figure:z.1f}" for figure in figures]
        counts = (str(errors.only_measured), str(errors.only_predicted))
        last = sensor == compared.sensors[-1]
        table.add_row(escape(sensor), str(errors.beams), *cells, *counts, end_section=last)
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate observation", description=__doc__)
    add_objects(parser)
    parser.add_argument("--recorded", type=Path, metavar="DIR", help="a recorded experiment instead of the simulation")
    parser.add_argument(
        "--predict",
        choices=["recorded", "mesh"],
        help="source of predictions for a recorded experiment (default: recorded, if it has any)",
    )
    parser.add_argument("--scans", type=count, default=10, help="scans per pose and sensor configuration (default 10)")
    parser.add_argument(
        "--range-noise-mm",
        type=amount,
        default=3.0,
        help="standard deviation of a range below half a metre (default 3)",
    )
    parser.add_argument(
        "--robot-xy-mm", type=amount, default=0.0, help="standard deviation of the robot's place (default 0)"
    )
    parser.add_argument(
        "--robot-yaw-deg", type=amount, default=0.0, help="standard deviation of its heading (default 0)"
    )
    parser.add_argument(
        "--noise-xy-mm", type=amount, default=0.0, help="standard deviation of the object's place (default 0)"
    )
    parser.add_argument(
        "--noise-yaw-deg", type=amount, default=0.0, help="standard deviation of its heading (default 0)"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of all errors (default 0)")
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
