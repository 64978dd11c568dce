"""The report of a replayed experiment, and its comparison with the results that the experiment expects."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

from pydantic import BaseModel

from voa_recordings.experiment_parts import ExpectedLook, ExpectedResults
from voa_recordings.replay.prediction_errors import PredictionErrors
from voa_recordings.selection import Selection


class BeforeLooks(BaseModel):
    """The best grasp before any look, and the probability that it succeeds; `best_grasp` is None if none can."""

    best_grasp: str | None
    expected_score: float


class LookValue(BaseModel):
    """The value of looking from one sensor configuration under one update rule, in success probability.

    Attributes:
        voa: Value of Assistance over predicted scans, computed before the look.
        aecd: the value over measured instead of predicted scans; None unless every pose has a measured scan.
        beliefs: after the scan that was measured at each pose, by that pose's name, in the order of the poses.
    """

    voa: float
    aecd: float | None
    beliefs: dict[str, list[float]]


class ExperimentReport(BaseModel):
    """Values of looks and prediction errors of a recorded experiment.

    Attributes:
        experiment: its name.
        poses: their names.
        sensors: names of the sensor configurations.
        before: the state before any look, under a uniform belief.
        rules: the values of looks, by update rule and sensor configuration.
        prediction: differences between measured and predicted ranges.
        selection: how the rows of the experiment were chosen; None: not stated.
    """

    experiment: str
    poses: list[str]
    sensors: list[str]
    before: BeforeLooks
    rules: dict[str, dict[str, LookValue]]
    prediction: PredictionErrors
    selection: Selection | None = None

    def document(self) -> dict[str, Any]:
        """Return the document of `--json`; it has `selection` only if the experiment states it."""
        return self.model_dump(exclude={"selection"} if self.selection is None else None)


def distance_from_expected(report: ExperimentReport, expected: ExpectedResults) -> float:
    """Return the largest absolute difference between a report and the expected results.

    Rules and sensors that the report lacks are not compared. Infinite if the best grasps differ, or if a value is None
    on one side only.
    """
    if report.before.best_grasp != expected.before.best_grasp:
        return math.inf
    differences = [abs(report.before.expected_score - expected.before.expected_score)]
    for rule, sensors in expected.rules.items():
        for sensor, wanted in sensors.items():
            actual = report.rules.get(rule, {}).get(sensor)
            if actual is not None:
                differences += _differences(actual, wanted, report.poses)
    return max(differences)


def _differences(actual: LookValue, wanted: ExpectedLook, poses: Sequence[str]) -> Iterable[float]:
    for one, other in ((actual.voa, wanted.voa), (actual.aecd, wanted.aecd)):
        if one is None or other is None:
            yield 0.0 if one == other else math.inf
        else:
            yield abs(one - other)
    for measured, belief in wanted.belief_after_measured_scan.items():
        for pose, share in zip(poses, actual.beliefs[measured], strict=True):
            yield abs(share - belief[pose])
