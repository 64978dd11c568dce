"""`voa evaluate all`: the paper's three evaluations as one HTML page, with the CSV files beside it.

On the simulated fleet, or with --recorded on a recorded experiment: observation errors, and VOA against what the
measured scans were worth. The same options and seed give the same page, byte for byte.
"""

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from voa_cli.evaluate.common import add_objects, objects_of, progress_bar
from voa_cli.evaluate.grasp_score import write_scores
from voa_cli.evaluate.looks import QUICK_NOTICE, add_setting, setting_of, write_pictures
from voa_cli.evaluate.observation import errors_of_record, write_errors
from voa_cli.progress import shown_progress
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_evaluation.looks.results import find
from voa_evaluation.looks.setting import Setting, usual_imperfections
from voa_evaluation.observation import ObservationErrors, simulated_errors
from voa_evaluation.report.measurement_sections import grasp_section, observation_section
from voa_evaluation.report.pictures import recorded_worth
from voa_evaluation.report.recorded_section import recorded_section
from voa_evaluation.report.sections import LEAD, looks_sections
from voa_evaluation.report.tables import write_csv, write_tables
from voa_fleet.errors import FleetError
from voa_fleet.show.page import Section, command, contents, notice, page, paragraph
from voa_fleet.world.objects import FleetObject
from voa_recordings.experiment import RecordedExperiment, read_experiment
from voa_recordings.replay.experiments import RULES, replay_experiment

PAGE = "report.html"
_SCANS, _QUICK_SCANS = 10, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate, write, say where; returns 0, or 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        if options.recorded is not None:
            report = _of_record(options, read_experiment(options.recorded))
        else:
            report = _of_fleet(options, objects_of(options))
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa evaluate all: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(report, sys.stdout, indent=1)
        print()
    else:
        print(f"{options.out / PAGE}: open it in a browser; the tables are beside it as CSV")
        if options.quick and options.recorded is None:
            print(QUICK_NOTICE)
    return 0


def _of_fleet(options: argparse.Namespace, targets: Sequence[FleetObject]) -> dict[str, Any]:
    setting = setting_of(options)
    scans = _QUICK_SCANS if options.quick else _SCANS
    errors = [_errors(target, scans, setting) for target in targets]
    with service_at(options.url) as client:
        found = find(client, targets, setting, progress_bar)
    folder = options.out
    tables = {
        target.name: write_scores(folder, target, each) for target, each in zip(targets, found.scores, strict=True)
    }
    write_tables(folder, found)
    sections = [
        grasp_section(found.scores, {name: files["picture"] for name, files in tables.items()}),
        _observed(folder, errors),
        *looks_sections(found, write_pictures(folder, found)),
    ]
    told = ["--object", *(shlex.quote(target.name) for target in targets), "--seed", str(setting.seed)]
    told += ["--drops", str(setting.drops), "--attempts", str(setting.attempts)]
    told += ["--sensitivity-drops", str(setting.sensitivity_drops), *(["--quick"] if options.quick else [])]
    _write_page(folder, "Value of Assistance on the simulated fleet", sections, " ".join(told), quick=options.quick)
    return {
        "grasp-score": [each.report() for each in found.scores],
        "observation": [each.report() for each in errors],
        "voa": found.report(),
    }


def _errors(target: FleetObject, scans: int, setting: Setting) -> ObservationErrors:
    total = scans * len(target.poses) * len(target.scenario.sensors)
    with progress_bar(f"{target.name}: scans", total) as advance:
        return simulated_errors(target, scans, usual_imperfections(), setting.seed, advance)


def _of_record(options: argparse.Namespace, experiment: RecordedExperiment) -> dict[str, Any]:
    errors = errors_of_record(experiment)
    with service_at(options.url) as client, shown_progress("replaying") as progress:
        report = replay_experiment(client, experiment, errors.source, (*RULES, "beam"), progress).model_dump()
    rows = [
        [rule, sensor, found["voa"], found["aecd"], len(found["beliefs"]), len(report["poses"])]
        for rule, sensors in report["rules"].items()
        for sensor, found in sensors.items()
    ]
    write_csv(options.out / "voa-recorded.csv", ("rule", "sensor", "voa", "aecd", "poses_measured", "poses"), rows)
    recorded_worth(options.out / "voa-recorded.png", experiment.name, report["rules"])
    sections = [
        _observed(options.out, [errors]),
        recorded_section(report, options.out / "voa-recorded.png"),
    ]
    title = f"Value of Assistance in a recorded experiment: {experiment.name}"
    _write_page(options.out, title, sections, "--recorded DIR")
    return {"observation": errors.report(), "voa": report}


def _observed(folder: Path, errors: Sequence[ObservationErrors]) -> Section:
    pictures = {}
    for each in errors:
        files = write_errors(folder, each)
        pictures[each.name] = [files["picture of the differences"], files["picture of the scans"]]
    return observation_section(errors, pictures)


def _write_page(folder: Path, title: str, sections: Sequence[Section], told: str, *, quick: bool = False) -> None:
    lead = [
        *([notice(QUICK_NOTICE)] if quick else []),
        paragraph(LEAD),
        paragraph(
            "Every figure is counted from what the page names beside it; the CSV files in the same folder hold the "
            "rows. The same command on the same machine and versions gives this page again, byte for byte:"
        ),
        command(f"voa evaluate all {told} --out DIR"),
        contents(sections),
    ]
    (folder / PAGE).write_text(page(title, lead, sections), encoding="utf-8")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate all", description=__doc__)
    add_objects(parser)
    parser.add_argument("--recorded", type=Path, metavar="DIR", help="a recorded experiment instead of the simulation")
    add_setting(parser)
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
