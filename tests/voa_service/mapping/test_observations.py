"""Observations: a scan or an outcome is compared with every pose once, and can then be applied to any belief."""

import math

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import PREDICTIONS, as_scan
from voa_core.errors import BeamGridMismatch, UnknownName
from voa_core.filtering import Belief
from voa_msgs.sessions import OutcomeRequest, ScanRequest
from voa_service.mapping.observations import outcome_observation, scan_observation

UNIFORM = Belief.uniform(3)


def scan(pose: str, sensor: str = "Q1") -> ScanRequest:
    return ScanRequest.model_validate({"sensor": sensor, "scan": as_scan(PREDICTIONS[sensor][pose])})


def test_a_scan_like_a_prediction_favours_its_pose() -> None:
    observation = scan_observation(core_scenario(), scan("P2"))
    updated = observation.applied_to(UNIFORM)
    assert (observation.kind, updated.report.accepted, updated.report.best_fit_pose) == ("scan", True, "P2")
    assert (updated.report.fit_rmsd_mm, updated.report.beams_compared) == (0.0, 4)
    distance = math.hypot(0.1, 0.5)  # P1 differs by 0.1 m, and by a return of 0.5 m where 1 m stands for none
    assert updated.belief.p[0] / updated.belief.p[1] == pytest.approx(math.exp(-distance))


def test_an_observation_can_be_applied_to_several_beliefs() -> None:
    observation = scan_observation(core_scenario(), scan("P2"))
    certain = Belief.of([1.0, 0.0, 0.0])
    first = observation.applied_to(UNIFORM).belief.p.tolist()
    assert observation.applied_to(certain).belief.p.tolist() == [1.0, 0.0, 0.0]
    assert observation.applied_to(UNIFORM).belief.p.tolist() == first


def test_a_scan_without_a_beam_to_compare_is_not_accepted_and_changes_nothing() -> None:
    missing = ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [None] * 4}})
    updated = scan_observation(core_scenario(), missing).applied_to(UNIFORM)
    assert (updated.report.accepted, updated.report.reason, updated.report.best_fit_pose) == (False, "no_beams", None)
    assert updated.belief is UNIFORM


def test_a_scan_with_other_beams_is_refused() -> None:
    with pytest.raises(BeamGridMismatch, match="got 3 ranges"):
        scan_observation(core_scenario(), ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [0.5] * 3}}))


@pytest.mark.parametrize(("success", "weights"), [(True, [0.9, 0.1, 0.2]), (False, [0.1, 0.9, 0.8])])
def test_an_outcome_weighs_poses_by_the_scores_of_its_grasp(success: bool, weights: list[float]) -> None:
    observation = outcome_observation(core_scenario(), OutcomeRequest(grasp="G1", success=success))
    updated = observation.applied_to(UNIFORM)
    assert updated.belief.p.tolist() == pytest.approx([weight / sum(weights) for weight in weights])
    assert (observation.kind, updated.report.beams_compared, updated.report.fit_rmsd_mm) == ("outcome", 0, None)


def test_an_outcome_of_an_unknown_grasp_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName) as refused:
        outcome_observation(core_scenario(), OutcomeRequest(grasp="G9", success=True))
    assert refused.value.known == ["G1", "G2"]


def test_a_scan_replaces_the_fit_of_a_session_and_an_outcome_keeps_it() -> None:
    scenario = core_scenario()
    assert scan_observation(scenario, scan("P2")).fit_rmsd_mm(7.0) == 0.0
    assert outcome_observation(scenario, OutcomeRequest(grasp="G1", success=True)).fit_rmsd_mm(7.0) == 7.0
