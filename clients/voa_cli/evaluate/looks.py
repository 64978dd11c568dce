"""Options and pictures of the paper's own evaluation of looks, which `voa evaluate all` runs on the fleet."""

import argparse
from dataclasses import replace
from pathlib import Path

from voa_cli.evaluate.common import count
from voa_cli.pictures import before_and_after
from voa_evaluation.looks.results import Results
from voa_evaluation.looks.setting import Setting
from voa_evaluation.report import pictures

QUICK = Setting(drops=4, attempts=2, sensitivity_drops=1)
"""Setting of a trial run: too few drops to conclude anything."""
QUICK_NOTICE = (
    "A trial run (--quick): it shows that the programs work. Its figures mean nothing, because they come from too few "
    "scans, attempts and drops; leave --quick out for figures that do."
)


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
