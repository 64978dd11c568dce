"""Prediction errors of a recorded experiment: the differences between measured and predicted ranges."""

import math
from collections.abc import Sequence
from typing import Literal

from pydantic import BaseModel

from voa_recordings.experiment import RecordedExperiment

Source = Literal["recorded", "mesh"]
"""Origin of the predictions: the experiment's `scans.csv`, or the experiment's mesh."""
Ranges = list[float | None]
"""A scan on every beam, metres; None for a no-return."""
Predictions = dict[str, dict[str, Ranges]]
"""Predicted scans by sensor and pose."""


class MeshAgainstRecorded(BaseModel):
    """Differences between ranges predicted from the mesh and those that `scans.csv` lists, metres."""

    beams: int
    max_abs_m: float


class PredictionErrors(BaseModel):
    """Absolute differences between measured and predicted ranges, over the beams that have both, millimetres.

    The figures are None where no beam has both. `against_recorded` is None unless predictions are from the mesh.
    """

    source: Source
    beams: int
    median_abs_mm: float | None
    p95_abs_mm: float | None
    max_abs_mm: float | None
    against_recorded: MeshAgainstRecorded | None


def prediction_errors(experiment: RecordedExperiment, predictions: Predictions, source: Source) -> PredictionErrors:
    """Compare an experiment's measured ranges with predicted ones, beam by beam.

    Args:
        experiment: with measured scans.
        predictions: a scan for every sensor and pose of the experiment.
        source: of the predictions.
    """
    errors_mm, from_recorded_m = [], []
    for (sensor, pose), scan in experiment.scans.items():
        ranges = predictions[sensor][pose]
        for beam in scan.beams:
            predicted = ranges[beam.index]
            if beam.measured is not None and predicted is not None:
                errors_mm.append(1e3 * abs(beam.measured - predicted))
            if beam.predicted is not None:
                coded = experiment.no_return_m if predicted is None else predicted
                from_recorded_m.append(abs(coded - beam.predicted))
    against = MeshAgainstRecorded(beams=len(from_recorded_m), max_abs_m=max(from_recorded_m, default=0.0))
    errors_mm.sort()
    return PredictionErrors(
        source=source,
        beams=len(errors_mm),
        median_abs_mm=percentile(errors_mm, 0.5),
        p95_abs_mm=percentile(errors_mm, 0.95),
        max_abs_mm=percentile(errors_mm, 1.0),
        against_recorded=against if source == "mesh" and from_recorded_m else None,
    )


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """Interpolate a percentile of ascending numbers linearly; None if there are none.

    Args:
        ordered: ascending.
        share: of the numbers below the percentile, 0 to 1.
    """
    if not ordered:
        return None
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])
