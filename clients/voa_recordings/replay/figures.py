"""How far two sets of numbers are apart: measured and predicted ranges, a report and what was expected of it."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal

from voa_recordings.experiment import RecordedExperiment

Source = Literal["recorded", "mesh"]
Ranges = list[float | None]
Predictions = dict[str, dict[str, Ranges]]


def prediction_errors(experiment: RecordedExperiment, predictions: Predictions, source: Source) -> dict[str, Any]:
    """The report's `prediction`: how far measured and predicted ranges are apart, over the rows that have both."""
    apart, from_recorded = [], []
    for (sensor, pose), scan in experiment.scans.items():
        predicted = predictions[sensor][pose]
        for beam in scan.beams:
            now = predicted[beam.index]
            if beam.measured is not None and now is not None:
                apart.append(1e3 * abs(beam.measured - now))
            if beam.predicted is not None:
                from_recorded.append(abs((experiment.no_return_m if now is None else now) - beam.predicted))
    against = {"beams": len(from_recorded), "max_abs_m": max(from_recorded)} if from_recorded else None
    apart.sort()
    return {
        "source": source,
        "beams": len(apart),
        "median_abs_mm": percentile(apart, 0.5),
        "p95_abs_mm": percentile(apart, 0.95),
        "max_abs_mm": percentile(apart, 1.0),
        "against_recorded": against if source == "mesh" else None,
    }


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """The linear percentile of ascending numbers; None of none."""
    if not ordered:
        return None
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


def distance_from_expected(report: dict[str, Any], expected: dict[str, Any], poses: Sequence[str]) -> float:
    """The largest difference between a report and an `expected.json`; infinite where they name other things."""
    if report["before"]["best_grasp"] != expected["before"]["best_grasp"]:
        return math.inf
    apart: list[float] = [abs(report["before"]["expected_score"] - expected["before"]["expected_score"])]
    for rule, sensors in expected["rules"].items():
        for sensor, want in sensors.items():
            have = report["rules"].get(rule, {}).get(sensor)
            if have is not None:
                apart += _differences(have, want, poses)
    return max(apart)


def _differences(have: dict[str, Any], want: dict[str, Any], poses: Sequence[str]) -> Iterable[float]:
    for figure in ("voa", "aecd"):
        if want[figure] is None or have[figure] is None:
            yield 0.0 if want[figure] == have[figure] else math.inf
        else:
            yield abs(have[figure] - want[figure])
    for measured, belief in want["belief_after_measured_scan"].items():
        for pose, share in zip(poses, have["beliefs"][measured], strict=True):
            yield abs(share - belief[pose])
