"""Reports of experiments against expected results: figures, and figures that one side lacks."""

import math

import pytest

from voa_recordings.experiment_parts import ExpectedBefore, ExpectedLook, ExpectedResults
from voa_recordings.replay.experiment_report import BeforeLooks, ExperimentReport, LookValue, distance_from_expected
from voa_recordings.replay.prediction_errors import PredictionErrors

NO_ERRORS = PredictionErrors(
    source="recorded", beams=0, median_abs_mm=None, p95_abs_mm=None, max_abs_mm=None, against_recorded=None
)
REPORT = ExperimentReport(
    experiment="box",
    poses=["P1", "P2"],
    sensors=["Q1"],
    before=BeforeLooks(best_grasp="G1", expected_score=0.5),
    rules={"margin": {"Q1": LookValue(voa=0.2, aecd=None, beliefs={"P1": [0.75, 0.25]})}},
    prediction=NO_ERRORS,
)


def expected(
    voa: float | None = 0.2, aecd: float | None = None, share: float = 0.75, best: str = "G1"
) -> ExpectedResults:
    look = ExpectedLook(voa=voa, aecd=aecd, belief_after_measured_scan={"P1": {"P1": share, "P2": 1.0 - share}})
    other = ExpectedLook(voa=9.0, aecd=9.0)
    before = ExpectedBefore(best_grasp=best, expected_score=0.5)
    return ExpectedResults(before=before, rules={"margin": {"Q1": look, "Q9": other}, "gaussian": {"Q1": other}})


@pytest.mark.parametrize(
    ("results", "distance"),
    [
        (expected(), 0.0),
        (expected(voa=0.3), 0.1),
        (expected(share=0.5), 0.25),
        (expected(aecd=0.2), math.inf),
        (expected(voa=None), math.inf),
        (expected(best="G2"), math.inf),
    ],
)
def test_the_distance_is_the_largest_difference_of_what_both_have(results: ExpectedResults, distance: float) -> None:
    assert distance_from_expected(REPORT, results) == pytest.approx(distance)
