"""`voa evaluate voa`: compare the promised value of looks with what they achieve, and ways of choosing looks.

Noisy scans of the project's objects are simulated by the thousand, weighed by the update that runs in the service, and
valued by the measured scores of the grasps that are then chosen. Drops in MuJoCo confirm it end to end. Prints the main
tables, and writes a page with the answer and all tables as CSV files and one JSON document into the output folder.
Equal options and seeds give equal files.
"""

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from voa_cli.evaluate.common import add_objects, count, objects_of, progress_bar
from voa_cli.evaluate.value_tables import answer, shown_tables
from voa_evaluation.report.value_report import value_sections, write_report
from voa_evaluation.values.results import Values
from voa_evaluation.values.running import evaluate_values
from voa_evaluation.values.setting import QUICK, Setting
from voa_evaluation.values.tables import document, write_tables
from voa_fleet.errors import FleetError
from voa_fleet.show.page import Notice

QUICK_VALUES_NOTICE = (
    "A trial run (--quick): few scans, beliefs, sessions and drops and no robot error of 3 cm, so that intervals are "
    "wide and small differences cannot show; leave --quick out for the figures of the report."
)
DOCUMENT = "values.json"


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate, write the files and print; return 0, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    try:
        values = evaluate_values(objects_of(options), setting_of(options), progress_bar, options.processes)
        files = write_values(options.out, values)
        notices = [Notice(QUICK_VALUES_NOTICE)] if options.quick else []
        files |= write_report(options.out, notices, value_sections(options.out, values), _command(options))
    except (FleetError, OSError) as error:
        print(f"voa evaluate voa: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(document(values), sys.stdout, indent=1)
        print()
        return 0
    console = Console()
    if options.quick:
        console.print(QUICK_VALUES_NOTICE, style="bold", highlight=False)
    for table in shown_tables(values):
        console.print(table)
    for line in answer(values):
        console.print(line, highlight=False)
    for name, file in files.items():
        console.print(f"{name}: {file}", highlight=False, soft_wrap=True)
    return 0


def setting_of(options: argparse.Namespace) -> Setting:
    """Make the setting that the options describe."""
    return replace(QUICK if options.quick else Setting(), seed=options.seed)


def write_values(folder: Path, values: Values) -> dict[str, Path]:
    """Write the CSV files and the JSON document; return their paths by the name of the table."""
    files = write_tables(folder, values)
    files["document"] = folder / DOCUMENT
    files["document"].write_text(json.dumps(document(values), indent=1) + "\n", encoding="utf-8")
    return files


def _command(options: argparse.Namespace) -> str:
    """Write the command line that gives the same page again; the number of processes does not change it."""
    names = [shlex.quote(target.name) for target in objects_of(options)]
    quick = ["--quick"] if options.quick else []
    return " ".join(["voa evaluate voa --object", *names, "--seed", str(options.seed), *quick, "--out DIR"])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate voa", description=__doc__)
    add_objects(parser)
    parser.add_argument("--quick", action="store_true", help="a trial run of at most 90 seconds, with wide intervals")
    parser.add_argument("--seed", type=int, default=0, help="seed of all random numbers (default 0)")
    parser.add_argument(
        "--processes", type=count, default=2, help="number of processes (default 2); it does not change the figures"
    )
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print the JSON document instead of tables")
    return parser
