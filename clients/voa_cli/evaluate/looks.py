"""`voa evaluate voa`: compare the Value of Assistance of looks with what they achieve, and VOA with other policies.

In simulation: objects are dropped many times, the lidar looks from every place, the service updates its belief by each
scan, and the arm attempts the best grasp. All policies (VOA, entropy, most beams, nearest, random, no look, and those
of --policy) have the same drops, scans and attempts. Writes CSV files and pictures into the output folder.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from voa_cli.evaluate.common import add_objects, count, objects_of, progress_bar
from voa_cli.evaluate.documents import looks_document
from voa_cli.pictures import before_and_after
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_evaluation.looks.findings import findings
from voa_evaluation.looks.results import Results, evaluate_looks
from voa_evaluation.looks.setting import BELIEFS, Setting
from voa_evaluation.report import pictures
from voa_evaluation.report.tables import write_tables
from voa_fleet.errors import FleetError

QUICK = Setting(drops=4, attempts=2, sensitivity_drops=1)
"""Setting of a trial run: too few drops to conclude anything."""
QUICK_NOTICE = (
    "A trial run (--quick): it shows that the programs work. Its figures mean nothing, because they come from too few "
    "scans, attempts and drops; leave --quick out for figures that do."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate, write the files and print; return 0, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    try:
        targets = objects_of(options)
        with service_at(options.url) as client:
            results = evaluate_looks(client, targets, setting_of(options), progress_bar)
        tables, drawn = write_tables(options.out, results), write_pictures(options.out, results)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa evaluate voa: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(looks_document(results), sys.stdout, indent=1)
        print()
        return 0
    if options.quick:
        Console().print(QUICK_NOTICE, style="bold", highlight=False)
    show(Console(), results)
    for kind, files in (("table", tables), ("picture", drawn)):
        for contents, file in files.items():
            Console().print(f"{kind}, {contents}: {file}", highlight=False, soft_wrap=True)
    return 0


def add_setting(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `Setting`."""
    usual = Setting()
    parser.add_argument("--drops", type=count, help=f"drops per object and kind of belief (default {usual.drops})")
    parser.add_argument("--attempts", type=count, help=f"attempts per grasp score (default {usual.attempts})")
    sensitivity = f"drops per object for the curves of sensitivity (default {usual.sensitivity_drops}, at most --drops)"
    parser.add_argument("--sensitivity-drops", type=count, help=sensitivity)
    parser.add_argument(
        "--policy",
        action="append",
        default=[],
        metavar="NAME",
        help="compare another policy too, such as one of an installed package; may be given several times",
    )
    parser.add_argument("--quick", action="store_true", help="a trial run with a few drops, whose figures mean nothing")
    parser.add_argument("--seed", type=int, default=0, help="seed of all random numbers (default 0)")
    parser.add_argument(
        "--processes", type=count, default=1, help="number of processes for the grasp scores (default 1)"
    )
    parser.add_argument(
        "--url", help="address of a running service; without it, one is started and ended with the command"
    )


def setting_of(options: argparse.Namespace) -> Setting:
    """Make the setting that the options describe."""
    by_name = {name: getattr(options, name) for name in ("drops", "attempts", "sensitivity_drops")}
    given = {name: value for name, value in by_name.items() if value is not None}
    usual = QUICK if options.quick else Setting()
    policies = tuple(dict.fromkeys([*usual.policies, *options.policy]))
    return replace(usual, **given, seed=options.seed, processes=options.processes, policies=policies)


def write_pictures(folder: Path, results: Results) -> dict[str, Path]:
    """Write all pictures; return their paths by the names that the sections of the page use."""
    names = results.rows.objects
    stems = ["policies", "scatter", "calibration", "sensitivity"]
    stems += [f"{kind}-{name}" for name in names for kind in ("example", "worth")]
    files = {stem: folder / f"voa-{stem}.png" for stem in stems}
    for name, example in zip(names, results.examples, strict=True):
        before_and_after(
            files[f"example-{name}"], example.scenario, example.before, example.after, example.sensor, example.pose
        )
        own = [worth for worth in results.worths if (worth.object, worth.kind) == (name, "uniform")]
        pictures.worth_by_place(files[f"worth-{name}"], own)
    pictures.success_by_policy(files["policies"], results.outcomes)
    pictures.voa_against_achieved(files["scatter"], results.worths, results.gains)
    pictures.calibration_plot(files["calibration"], results.bins)
    pictures.sensitivity_curves(files["sensitivity"], results.levels)
    return files


def show(console: Console, results: Results) -> None:
    """Print the successes per policy, and the number of comparisons per verdict."""
    for kind in BELIEFS:
        table = Table(title=f"Successes per policy, all objects, {kind} belief", title_justify="left")
        table.add_column("rule")
        for policy in results.setting.policies:
            table.add_column(policy, justify="right")
        for rule in results.rows.rules:
            own = [each for each in results.outcomes if (each.object, each.kind, each.rule) == (None, kind, rule)]
            table.add_row(rule, *(f"{each.rate.successes}/{each.rate.drops}" for each in own))
        console.print(table)
    comparisons = findings(results)
    for verdict in ("better", "worse", "no difference shown"):
        own_verdict = [each for each in comparisons if each.verdict == verdict]
        console.print(
            f"VOA against another policy, {verdict}: {len(own_verdict)} of {len(comparisons)}", highlight=False
        )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate voa", description=__doc__)
    add_objects(parser)
    add_setting(parser)
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
