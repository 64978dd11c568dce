"""`voa evaluate all`: the evaluation of values and the paper's own three as one HTML page, with CSV files beside it.

In simulation, or with --recorded on a recorded experiment: how its rows were chosen, errors of predicted scans, and VOA
against the value of the measured scans. Equal options and seeds give equal pages, byte for byte.
"""

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from voa_cli.evaluate.common import add_objects, objects_of, progress_bar
from voa_cli.evaluate.documents import grasp_score_document, looks_document, observation_document
from voa_cli.evaluate.grasp_score import write_scores
from voa_cli.evaluate.looks import QUICK_NOTICE, add_setting, setting_of, write_pictures
from voa_cli.evaluate.observation import errors_of_record, write_errors
from voa_cli.evaluate.values import setting_of as setting_of_values
from voa_cli.evaluate.values import write_values
from voa_cli.progress import shown_progress
from voa_client import VoaClientError
from voa_client.local import service_at
from voa_evaluation.looks.results import evaluate_looks
from voa_evaluation.looks.setting import Setting, default_imperfections
from voa_evaluation.observation import ObservationErrors, simulated_errors
from voa_evaluation.report.measurement_sections import grasp_section, observation_section
from voa_evaluation.report.pictures import recorded_values
from voa_evaluation.report.recorded_section import recorded_section
from voa_evaluation.report.sections import LEAD, PAPER_LEAD, looks_section
from voa_evaluation.report.tables import write_csv, write_tables
from voa_evaluation.report.value_report import PAGE, paper_section, value_sections, write_report
from voa_evaluation.values.running import evaluate_values
from voa_evaluation.values.tables import document
from voa_fleet.errors import FleetError
from voa_fleet.show.page import Block, Command, Notice, Paragraph, Section, write_page
from voa_fleet.world.objects import FleetObject
from voa_msgs.updates import BUILT_IN
from voa_recordings.experiment import RecordedExperiment, read_experiment
from voa_recordings.replay.experiments import replay_experiment
from voa_recordings.selection import describe_selection

_SCANS, _QUICK_SCANS = 10, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate, write the files and print their place; return 0, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        if options.recorded is not None:
            document = _evaluate_recorded(options, read_experiment(options.recorded))
        else:
            document = _evaluate_simulated(options, objects_of(options))
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa evaluate all: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(document, sys.stdout, indent=1)
        print()
    else:
        print(f"{options.out / PAGE}: open it in a browser; the tables are CSV files in the same folder")
        if options.quick and options.recorded is None:
            print(QUICK_NOTICE)
    return 0


def _evaluate_simulated(options: argparse.Namespace, targets: Sequence[FleetObject]) -> dict[str, Any]:
    setting = setting_of(options)
    scans = _QUICK_SCANS if options.quick else _SCANS
    errors = [_errors(target, scans, setting) for target in targets]
    with service_at(options.url) as client:
        results = evaluate_looks(client, targets, setting, progress_bar)
    values = evaluate_values(targets, setting_of_values(options), progress_bar, options.processes)
    folder = options.out
    write_values(folder, values)
    tables = {
        target.name: write_scores(folder, target, each) for target, each in zip(targets, results.scores, strict=True)
    }
    write_tables(folder, results)
    looks = looks_section(results, write_pictures(folder, results))
    parts = [
        grasp_section(results.scores, {name: files["picture"] for name, files in tables.items()}),
        _observed(folder, errors),
        looks,
    ]
    notices = [Notice(QUICK_NOTICE)] if options.quick else []
    sections = [*value_sections(folder, values), paper_section([Paragraph(PAPER_LEAD), looks.blocks[0]], parts)]
    write_report(folder, notices, sections, _command(options, targets, setting))
    return {
        "values": document(values),
        "grasp-score": [grasp_score_document(each) for each in results.scores],
        "observation": [observation_document(each) for each in errors],
        "voa": looks_document(results),
    }


def _command(options: argparse.Namespace, targets: Sequence[FleetObject], setting: Setting) -> str:
    """Write the command line that gives the same page again; the number of processes does not change it."""
    words = ["voa evaluate all --object", *(shlex.quote(target.name) for target in targets)]
    words += ["--seed", str(setting.seed), "--drops", str(setting.drops), "--attempts", str(setting.attempts)]
    words += ["--sensitivity-drops", str(setting.sensitivity_drops), *(["--quick"] if options.quick else [])]
    words += [part for name in options.policy for part in ("--policy", shlex.quote(name))]
    return " ".join([*words, "--out DIR"])


def _errors(target: FleetObject, scans: int, setting: Setting) -> ObservationErrors:
    total = scans * len(target.poses) * len(target.scenario.sensors)
    with progress_bar(f"{target.name}: scans", total) as advance:
        return simulated_errors(target, scans, default_imperfections(), setting.seed, advance)


def _evaluate_recorded(options: argparse.Namespace, experiment: RecordedExperiment) -> dict[str, Any]:
    errors = errors_of_record(experiment)
    with service_at(options.url) as client, shown_progress("replaying") as progress:
        report = replay_experiment(client, experiment, errors.source, tuple(BUILT_IN), progress)
    rows = [
        [rule, sensor, look.voa, look.aecd, len(look.beliefs), len(report.poses)]
        for rule, sensors in report.rules.items()
        for sensor, look in sensors.items()
    ]
    write_csv(options.out / "voa-recorded.csv", ("rule", "sensor", "voa", "aecd", "poses_measured", "poses"), rows)
    recorded_values(options.out / "voa-recorded.png", report)
    sections = [
        _observed(options.out, [errors]),
        recorded_section(report, options.out / "voa-recorded.png"),
    ]
    title = f"Value of Assistance in a recorded experiment: {experiment.name}"
    selection = describe_selection(experiment.selection)
    chosen = Notice(selection) if experiment.selection == "matched" else Paragraph(selection)
    _write_page(options.out, title, sections, "--recorded DIR", first=[chosen])
    if not options.json:
        print(selection)
    return {"observation": observation_document(errors), "voa": report.document()}


def _observed(folder: Path, errors: Sequence[ObservationErrors]) -> Section:
    pictures = {}
    for each in errors:
        files = write_errors(folder, each)
        pictures[each.name] = [files["picture of the differences"], files["picture of the scans"]]
    return observation_section(errors, pictures)


def _write_page(
    folder: Path, title: str, sections: Sequence[Section], repeated: str, *, first: Sequence[Block] = ()
) -> None:
    lead: list[Block] = [
        *first,
        Paragraph(LEAD),
        Paragraph(
            "Every figure is computed from the counts that the page names with it; the CSV files in the same folder "
            "hold the rows. This command on the same machine and versions gives this page again, byte for byte:"
        ),
        Command(f"voa evaluate all {repeated} --out DIR"),
    ]
    write_page(folder / PAGE, title, lead, sections, contents=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa evaluate all", description=__doc__)
    add_objects(parser)
    parser.add_argument("--recorded", type=Path, metavar="DIR", help="a recorded experiment instead of the simulation")
    add_setting(parser)
    parser.add_argument("--out", type=Path, default=Path("voa-evaluation"), help="folder (default voa-evaluation)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
