"""Remarks on a recorded experiment: what its files contradict, lack, or make look wrong, in words."""

import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from voa_recordings.experiment import RecordedExperiment
from voa_recordings.experiment_parts import ExperimentFile
from voa_recordings.experiment_rows import SCANS
from voa_recordings.experiment_writing import EXPERIMENT
from voa_recordings.selection import NOT_STATED

_MOST_COMPARED = 20_000_000
"""Number of pairs of beams that are compared to notice scans of another pose."""
_CLEARLY = 1.33
"""Factor by which another pose must fit better for a scan to look like a scan of that pose."""
_AT_LEAST_M = 0.002
"""Difference of the fits of two poses, metres, below which neither is better."""
_MOST_APART_M = 0.03
"""Difference of a measured and a predicted range, metres, that larger ones and edges count as."""

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Remark:
    """A mistake in a recorded experiment (error), or a probable one (warning), in one sentence."""

    severity: Severity
    text: str


def content_remarks(folder: Path, content: ExperimentFile) -> Iterator[Remark]:
    """List the mistakes of `experiment.json`: scores, mesh, geometry, selection."""
    if content.scores is None and (content.successes is None or content.attempts is None):
        yield Remark("error", f"{EXPERIMENT}: expected `scores`, or `successes` with `attempts`")
    yield from _absent_scores("scores", content.scores, content)
    yield from _absent_scores("successes", content.successes, content)
    yield from _out_of_range("scores", content.scores, 1)
    yield from _out_of_range("successes", content.successes, content.attempts)
    if content.object is not None:
        yield from _object_remarks(folder / content.object.mesh, content)
    if content.selection is None:
        yield Remark("warning", NOT_STATED)


Table = dict[str, dict[str, float]] | dict[str, dict[str, int]] | None


def _absent_scores(name: str, table: Table, content: ExperimentFile) -> Iterator[Remark]:
    for grasp in content.grasps if table is not None else ():
        absent = [pose.name for pose in content.poses if pose.name not in (table or {}).get(grasp, {})]
        if absent:
            yield Remark("error", f"{EXPERIMENT}: {name}: grasp {grasp!r} has none at {', '.join(absent)}")


def _out_of_range(name: str, table: Table, most: int | None) -> Iterator[Remark]:
    for grasp, row in (table or {}).items():
        for pose, value in row.items():
            if most is not None and not 0 <= value <= most:
                text = f"{name}: {grasp!r} at {pose!r}: expected 0 to {most}, got {value:g}"
                yield Remark("error", f"{EXPERIMENT}: {text}")


def _object_remarks(mesh: Path, content: ExperimentFile) -> Iterator[Remark]:
    if not mesh.is_file():
        yield Remark("error", f"{EXPERIMENT}: object.mesh: there is no file {mesh}")
    without = [pose.name for pose in content.poses if pose.position is None or pose.quaternion_wxyz is None]
    if without:
        text = f"predictions from the mesh need position and quaternion_wxyz, which {', '.join(without)} lack"
        yield Remark("warning", f"{EXPERIMENT}: {text}")


def scan_remarks(experiment: RecordedExperiment) -> Iterator[Remark]:
    """List scans that are missing, and scans that look like scans of another pose."""
    poses, sensors = experiment.pose_names, [sensor.name for sensor in experiment.sensors]
    measured = [(sensor, pose) for sensor in sensors for pose in poses if experiment.scan(sensor, pose).was_measured]
    for sensor in sensors:
        absent = [pose for pose in poses if (sensor, pose) not in measured]
        if absent and len(absent) < len(poses):
            yield Remark("warning", f"{sensor}: no scan at {', '.join(absent)}, so that its AECD is undefined")
        elif absent:
            yield Remark("warning", f"{sensor}: no scan at any pose")
    without = [
        pair for pair in measured if not any(beam.predicted is not None for beam in experiment.scan(*pair).beams)
    ]
    if without and len(without) == len(measured):
        text = f"{SCANS}: no scan has predicted ranges: use --predict mesh"
        yield Remark("warning", text)
    elif len(measured) * len(poses) * experiment.lidar.beams <= _MOST_COMPARED:
        yield from (Remark("warning", text) for pair in measured for text in _other_pose(experiment, *pair))


def _other_pose(experiment: RecordedExperiment, sensor: str, pose: str) -> Iterator[str]:
    """A sentence where a scan fits another pose clearly better than the one that it is said to be of."""
    scan = experiment.measured_ranges(sensor, pose)
    apart = {
        name: _difference(scan, experiment.predicted_ranges(sensor, name), experiment.no_return_m)
        for name in experiment.pose_names
        if any(beam.predicted is not None for beam in experiment.scan(sensor, name).beams)
    }
    best = min(apart, key=lambda name: apart[name], default=pose)
    if pose in apart and apart[pose] > max(_CLEARLY * apart[best], apart[best] + _AT_LEAST_M):
        yield (
            f"{sensor} at {pose}: the scan fits {best} better (ranges differ by {1e3 * apart[best]:.0f} mm on average, "
            f"from {pose} by {1e3 * apart[pose]:.0f} mm): did the object lie at {pose}?"
        )


def _difference(one: Sequence[float | None], other: Sequence[float | None], no_return_m: float) -> float:
    """Mean difference of two scans, metres, over the beams on which any returns; each counts as 3 cm at most."""
    pairs = [(a, b) for a, b in zip(one, other, strict=True) if a is not None or b is not None]
    apart = [
        abs(min(no_return_m if a is None else a, no_return_m) - min(no_return_m if b is None else b, no_return_m))
        for a, b in pairs
    ]
    return statistics.fmean(min(value, _MOST_APART_M) for value in apart) if apart else 0.0
