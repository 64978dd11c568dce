"""Check a recorded experiment: every mistake of its files in words, and how many scans there are of each pose."""

import statistics
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from voa_client.message_files import read_file
from voa_recordings.experiment import read_experiment
from voa_recordings.experiment_parts import ExperimentFile, InvalidExperiment
from voa_recordings.experiment_remarks import Remark, Severity, content_remarks, scan_remarks
from voa_recordings.experiment_rows import SCANS, BeamRow, beam_row, raw_rows
from voa_recordings.experiment_writing import EXPERIMENT, Pair

_MOST_LINES = 20
"""Number of wrong rows that are listed; of more, the number is stated."""
_MILLIMETRES = 30.0
"""Median measured range, in the file's unit, above which the file is taken to be in millimetres."""


@dataclass
class ExperimentCheck:
    """Result of the check of a recorded experiment.

    Attributes:
        name: of the experiment; None: `experiment.json` cannot be read.
        remarks: mistakes, errors first.
        measured: number of measured scans, 0 or 1, by sensor configuration and pose.
        beams: number of beams with a measured range, by sensor configuration and pose.
        sensors, poses: their names, in the order of the file.
    """

    name: str | None = None
    remarks: list[Remark] = field(default_factory=list)
    measured: Counter[Pair] = field(default_factory=Counter)
    beams: Counter[Pair] = field(default_factory=Counter)
    sensors: Sequence[str] = ()
    poses: Sequence[str] = ()

    @property
    def errors(self) -> int:
        """Number of errors, which a replay would refuse or misread."""
        return sum(remark.severity == "error" for remark in self.remarks)

    def add(self, severity: Severity, text: str) -> None:
        """Append a remark."""
        self.remarks.append(Remark(severity, text))


def check_experiment(folder: Path) -> ExperimentCheck:
    """Check a folder with a recorded experiment; every mistake is listed, not the first one alone."""
    check = ExperimentCheck()
    source = folder / EXPERIMENT
    if not source.is_file():
        check.add("error", f"{folder} has no {EXPERIMENT}: expected a folder with a recorded experiment")
        return check
    try:
        content = read_file(ExperimentFile, source, InvalidExperiment)
    except InvalidExperiment as error:
        check.add("error", str(error))
        return check
    check.name = content.name
    check.sensors = [sensor.name for sensor in content.sensors]
    check.poses = [pose.name for pose in content.poses]
    for remark in content_remarks(folder, content):
        check.remarks.append(remark)
    _check_rows(folder / SCANS, content, check)
    if not check.errors:
        for remark in scan_remarks(read_experiment(folder)):
            check.remarks.append(remark)
    check.remarks.sort(key=lambda remark: remark.severity != "error")
    return check


def _check_rows(source: Path, content: ExperimentFile, check: ExperimentCheck) -> None:
    """Read every row of `scans.csv`, count the measured beams, and list the rows that are wrong."""
    if not source.is_file():
        check.add("error", f"there is no file {source}: expected one row per beam in it")
        return
    wrong: list[str] = []
    lines_of: dict[tuple[str, str, int], int] = {}
    heights: dict[Pair, float | None] = {}
    measured: list[float] = []
    try:
        with source.open(encoding="utf-8", newline="") as lines:
            for number, cells in raw_rows(source, lines):
                try:
                    row = beam_row(cells, content.lidar, check.sensors, check.poses)
                except InvalidExperiment as error:
                    wrong.append(f"{SCANS}, line {number}: {error}")
                    continue
                wrong += _contradictions(row, number, lines_of, heights)
                if row.beam.measured is not None:
                    check.beams[row.sensor, row.pose] += 1
                    measured.append(row.beam.measured)
    except InvalidExperiment as error:
        check.add("error", str(error))
        return
    for text in islice(wrong, _MOST_LINES):
        check.add("error", text)
    if len(wrong) > _MOST_LINES:
        check.add("error", f"{SCANS}: {len(wrong) - _MOST_LINES} more rows are wrong")
    check.measured.update(dict.fromkeys(check.beams, 1))
    for text in _range_errors(measured, content.observation.no_return):
        check.add("error", text)


def _contradictions(
    row: BeamRow, number: int, lines_of: dict[tuple[str, str, int], int], heights: dict[Pair, float | None]
) -> Iterator[str]:
    """Contradictions of a row to earlier rows of its scan, which are remembered."""
    beam = (row.sensor, row.pose, row.beam.index)
    before = lines_of.setdefault(beam, number)
    if before != number:
        yield (
            f"{SCANS}, line {number}: line {before} has that beam of {row.sensor} at {row.pose} already: expected one "
            "scan for each sensor configuration and pose"
        )
    height = heights.setdefault((row.sensor, row.pose), row.height_m)
    if height != row.height_m:
        yield (
            f"{SCANS}, line {number}: plane_height: expected {height} m as in the other rows of {row.sensor} at "
            f"{row.pose}, got {row.height_m}"
        )


def _range_errors(measured: Sequence[float], no_return_m: float) -> Iterator[str]:
    """Mistakes that all measured ranges together show."""
    if not measured:
        yield f"{SCANS}: no scan is measured yet: fill in the column `measured`, in metres"
    elif statistics.median(measured) > _MILLIMETRES:
        yield f"{SCANS}: half of the measured ranges are above {_MILLIMETRES:g}: expected metres, not millimetres"
    elif min(measured) > no_return_m:
        yield (
            f"{EXPERIMENT}: observation.no_return: every measured range is beyond {no_return_m:g} m and counts as a "
            "no-return"
        )
