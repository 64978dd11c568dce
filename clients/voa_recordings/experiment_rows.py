"""Rows of `scans.csv`, the scans of a recorded experiment: one beam each, read and written."""

import csv
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from voa_recordings.experiment_parts import ExperimentLidar, InvalidExperiment

SCANS = "scans.csv"
COLUMNS = ("sensor", "pose", "plane_height", "angle_deg", "measured", "predicted")
"""Columns of `scans.csv`, in the order in which they are written; `plane_height` may be absent."""
_NEEDED = tuple(name for name in COLUMNS if name != "plane_height")


@dataclass(frozen=True)
class Beam:
    """A row of `scans.csv`: the beam's index, and its measured and predicted range; metres, None for a no-return."""

    index: int
    measured: float | None
    predicted: float | None


@dataclass(frozen=True)
class BeamRow:
    """A row of `scans.csv` with the names of its sensor configuration and pose, and its plane height in metres."""

    sensor: str
    pose: str
    height_m: float | None
    beam: Beam


def raw_rows(source: Path, lines: Iterable[str]) -> Iterator[tuple[int, dict[str, str]]]:
    """Read the rows of a CSV file, each with the number of its line.

    Args:
        source: the file, for messages.
        lines: its lines, the header first.

    Raises:
        InvalidExperiment: the file is not CSV in UTF-8, or lacks a column.
    """
    try:
        reader = csv.DictReader(lines)
        absent = [name for name in _NEEDED if name not in (reader.fieldnames or ())]
        if absent:
            raise InvalidExperiment(f"{source}: expected columns {', '.join(_NEEDED)}, and {absent[0]} is missing")
        for row in reader:
            yield reader.line_num, row
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidExperiment(f"{source} is not CSV in UTF-8: {error}") from error


def beam_row(
    row: Mapping[str, str], lidar: ExperimentLidar, sensors: Collection[str], poses: Collection[str]
) -> BeamRow:
    """Interpret a row of `scans.csv`.

    Args:
        row: text by column.
        lidar: whose grid the angle must be on.
        sensors: names of the experiment's sensor configurations.
        poses: names of its poses.

    Raises:
        InvalidExperiment: the experiment has no such sensor, pose or beam, or a value is no range; the message says so.
    """
    for what, name, names in (("sensor", row["sensor"], sensors), ("pose", row["pose"], poses)):
        if name not in names:
            raise InvalidExperiment(f"experiment.json has no {what} {name!r}, only {', '.join(sorted(names))}")
    try:
        angle_deg = float(row["angle_deg"])
    except (TypeError, ValueError):
        raise InvalidExperiment(f"angle_deg: expected degrees, got {row['angle_deg']!r}") from None
    if not math.isfinite(angle_deg):
        raise InvalidExperiment(f"angle_deg: expected degrees, got {row['angle_deg']!r}")
    beam = Beam(lidar.beam(angle_deg), _metres(row, "measured"), _metres(row, "predicted"))
    return BeamRow(row["sensor"], row["pose"], _metres(row, "plane_height"), beam)


def _metres(row: Mapping[str, str], column: str) -> float | None:
    """Read a range; None for an empty one, NaN or infinity."""
    text = row.get(column)
    try:
        value = float(text) if text and not text.isspace() else math.nan
    except ValueError:
        raise InvalidExperiment(f"{column}: expected a number of metres, or nothing, got {text!r}") from None
    if value < 0.0:
        raise InvalidExperiment(f"{column}: expected at least 0 m, got {value:g}")
    return value if math.isfinite(value) else None


def write_rows(file: Path, rows: Iterable[BeamRow], lidar: ExperimentLidar) -> None:
    """Write `scans.csv`, with an empty cell for a no-return.

    Args:
        file: to be written.
        rows: of all scans.
        lidar: whose grid gives the angles.
    """
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            angle_deg = lidar.angle_min_deg + row.beam.index * lidar.angle_increment_deg
            ranges = (_text(row.beam.measured), _text(row.beam.predicted))
            writer.writerow([row.sensor, row.pose, _text(row.height_m), f"{angle_deg:.8g}", *ranges])


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.8g}"


def rows_of_scan(
    sensor: str,
    pose: str,
    height_m: float | None,
    measured: Sequence[float | None] | None,
    predicted: Sequence[float | None],
    window: Collection[int] = (),
) -> Iterator[BeamRow]:
    """Make the rows of one scan: every beam with a measured or predicted range, and those of a window.

    Args:
        sensor: name of the sensor configuration.
        pose: name of the pose.
        height_m: of the scan plane over the table, metres.
        measured: a range for each beam of the lidar, metres, None for a no-return; None: not measured yet.
        predicted: a range for each beam, metres, None for a no-return.
        window: indices of beams that get a row in any case.
    """
    for index, expected in enumerate(predicted):
        own = None if measured is None else measured[index]
        if own is not None or expected is not None or index in window:
            yield BeamRow(sensor, pose, height_m, Beam(index, own, expected))
