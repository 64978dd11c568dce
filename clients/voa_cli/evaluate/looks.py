"""`voa evaluate voa`: whether looks are worth what VOA says beforehand, and what choosing by it brings.

In simulation: objects are put down many times, the lidar looks from everywhere, the service updates its belief from
each scan, the arm attempts the best grasp. Policies (VOA, entropy, most beams, nearest, random, no look) meet the same
drops, scans and attempts. Writes CSV files and pictures into the output folder.
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
from voa_cli.pictures import before_and_after
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_evaluation import pictures
from voa_evaluation.looks.choices import POLICIES
from voa_evaluation.looks.findings import findings
from voa_evaluation.looks.results import Found, find
from voa_evaluation.looks.setting import BELIEFS, Setting
from voa_evaluation.report.tables import write_tables
from voa_fleet.errors import FleetError

QUICK = Setting(drops=4, attempts=2, sensitivity_drops=1)
"""To see that everything works; too few drops to conclude anything."""
QUICK_NOTICE = (
    "A trial run (--quick): it shows that everything works. Its figures mean nothing, because they come from too few "
    "scans, attempts and drops; leave --quick out for figures that do."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate, write, print; returns 0, or 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    try:
        targets = objects_of(options)
        with service_at(options.url) as client:
            found = find(client, targets, setting_of(options), progress_bar)
        tables, drawn = write_tables(options.out, found), write_pictures(options.out, found)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa evaluate voa: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(found.report(), sys.stdout, indent=1)
        print()
        return 0
    if options.quick:
        Console().print(QUICK_NOTICE, style="bold", highlight=False)
    show(Console(), found)
    for kind, files in (("table", tables), ("picture", drawn)):
        for what, file in files.items():
            Console().print(f"{kind}, {what}: {file}", highlight=False, soft_wrap=True)
    return 0


def add_setting(parser: argparse.ArgumentParser) -> None:
    """The options of a `Setting`."""
    usual = Setting()
    parser.add_argument("--drops", type=count, help=f"per object and kind of belief (default {usual.drops})")
    parser.add_argument("--attempts", type=count, help=f"per grasp score (default {usual.attempts})")
    told = f"per object, for the curves (default {usual.sensitivity_drops}, at most --drops)"
    parser.add_argument("--sensitivity-drops", type=count, help=told)
    parser.add_argument(
        "--quick", action="store_true", help="a few drops: to see that it works; the figures mean nothing"
    )
    parser.add_argument("--seed", type=int, default=0, help="of all chance (default 0)")
    parser.add_argument("--processes", type=count, default=1, help="for the grasp scores (default 1)")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")


def setting_of(options: argparse.Namespace) -> Setting:
    """The setting that the options name."""
    told = {name: getattr(options, name) for name in ("drops", "attempts", "sensitivity_drops")}
    given = {name: value for name, value in told.items() if value is not None}
    usual = QUICK if options.quick else Setting()
    return replace(usual, **given, seed=options.seed, processes=options.processes)


def write_pictures(folder: Path, found: Found) -> dict[str, Path]:
    """Write all pictures; returns them by the names that the page knows them by."""
    names = found.rows.objects
    stems = ["policies", "scatter", "calibration", "sensitivity"]
    stems += [f"{what}-{name}" for name in names for what in ("example", "worth")]
    files = {stem: folder / f"voa-{stem}.png" for stem in stems}
    for name, example in zip(names, found.examples, strict=True):
        before_and_after(
            files[f"example-{name}"], example.scenario, example.before, example.after, example.sensor, example.pose
        )
        own = [worth for worth in found.worths if (worth.object, worth.kind) == (name, "uniform")]
        pictures.worth_by_place(files[f"worth-{name}"], own)
    pictures.success_by_policy(files["policies"], found.outcomes)
    pictures.voa_against_achieved(files["scatter"], found.worths, found.gains)
    pictures.calibration_plot(files["calibration"], found.bins)
    pictures.sensitivity_curves(files["sensitivity"], found.levels)
    return files


def show(console: Console, found: Found) -> None:
    """Success per policy, and how many comparisons came out which way."""
    for kind in BELIEFS:
        table = Table(title=f"Successes per policy, all objects, {kind} belief", title_justify="left")
        table.add_column("rule")
        for policy in POLICIES:
            table.add_column(policy, justify="right")
        for rule in found.rows.rules:
            own = [each for each in found.outcomes if (each.object, each.kind, each.rule) == (None, kind, rule)]
            table.add_row(rule, *(f"{each.rate.successes}/{each.rate.drops}" for each in own))
        console.print(table)
    told = findings(found)
    for verdict in ("better", "worse", "no difference shown"):
        own_verdict = [each for each in told if each.verdict == verdict]
        console.print(f"VOA against another policy, {verdict}: {len(own_verdict)} of {len(told)}", highlight=False)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate voa", description=__doc__)
    add_objects(parser)
    add_setting(parser)
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
