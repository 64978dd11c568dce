"""Updates of a session: from its stored state and an observation to belief, record of looks and report."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import pytest

from tests.support.scenarios import core_scenario
from tests.support.serving import PREDICTIONS, Json, as_scan
from voa_core.estimates import Attempts
from voa_core.filtering import Belief
from voa_core.lidars import SensorUncertainty
from voa_core.places import Place
from voa_core.scenario import Scenario
from voa_msgs.looks import AtPlace
from voa_msgs.sessions import OutcomeRequest, ScanRequest
from voa_service.mapping.looks import LookRecord, PlaceRecord, record_of
from voa_service.mapping.observations import ScanObservation, outcome_observation, scan_observation, viewpoint_of
from voa_service.mapping.updates import Updated, updated_by_outcome, updated_by_scan
from voa_store.records import SessionState

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
UNIFORM = Belief.uniform(3)
EMPTY: Json = {"sensor": "Q1", "scan": {"ranges": [None] * 4, "no_return": [0, 1, 2, 3]}}


def state(belief: Belief = UNIFORM, **changes: Any) -> SessionState:
    return replace(SessionState("S", "scenario", 0, belief, UNIFORM, 7.0, NOON, NOON), **changes)


def scan(scenario: Scenario, pose: str = "P2", sensor: str = "Q1") -> ScanObservation:
    body = {"sensor": sensor, "scan": as_scan(PREDICTIONS[sensor][pose])}
    return scan_observation(scenario, ScanRequest.model_validate(body))


def no_place(index: int, copies: int) -> Place:
    raise AssertionError("looks whose copies are all alike need no weights of earlier looks")


def by_scan(before: SessionState, observation: ScanObservation) -> Updated:
    return updated_by_scan(before, observation, no_place)


def after(before: SessionState, updated: Updated) -> SessionState:
    return replace(before, version=before.version + 1, belief=updated.belief, looks=updated.record.text())


def test_a_scan_is_applied_to_the_belief_of_the_session_and_replaces_its_fit() -> None:
    updated = by_scan(state(), scan(core_scenario()))
    assert updated.report is not None
    assert (updated.accepted, updated.report.best_fit_pose, updated.report.beams_compared) == (True, "P2", 4)
    assert updated.fit_rmsd_mm == updated.report.fit_rmsd_mm == 0.0
    assert updated.belief.p[0] / updated.belief.p[1] == pytest.approx(math.exp(-math.hypot(0.1, 0.5)))
    assert [(place.viewpoint.listed, place.looks, place.copies) for place in updated.record.places] == [("Q1", 1, 1)]


def test_an_observation_can_be_applied_to_several_sessions() -> None:
    observation, certain = scan(core_scenario()), Belief.of([1.0, 0.0, 0.0])
    first = by_scan(state(), observation).belief.p.tolist()
    assert by_scan(state(certain), observation).belief.p.tolist() == [1.0, 0.0, 0.0]
    assert by_scan(state(), observation).belief.p.tolist() == first


def test_looks_of_one_place_are_counted_and_need_no_weights_where_all_copies_are_alike() -> None:
    scenario, before = core_scenario(), state()
    for sensor in ("Q1", "Q2", "Q1"):
        before = after(before, by_scan(before, scan(scenario, sensor=sensor)))
    places = record_of(before.looks).places
    assert [(place.viewpoint.listed, place.looks) for place in places] == [("Q1", 2), ("Q2", 1)]


def test_a_scan_without_a_beam_to_compare_is_not_accepted_and_changes_nothing() -> None:
    missing = ScanRequest.model_validate({"sensor": "Q1", "scan": {"ranges": [None] * 4}})
    updated = by_scan(state(), scan_observation(core_scenario(), missing))
    assert updated.report is not None
    assert (updated.accepted, updated.report.reason, updated.report.best_fit_pose) == (False, "no_beams", None)
    assert updated.belief is UNIFORM
    assert (updated.fit_rmsd_mm, updated.record, updated.place) == (7.0, LookRecord(), None)


def test_a_scan_that_the_nearest_poses_share_forgets_earlier_looks_and_outcomes() -> None:
    margin = {"rule": "margin", "margin_m": 0.001, "no_return_m": 1.0, "on_no_match": "nearest"}
    scenario = core_scenario(update=margin)
    far = ScanRequest.model_validate({"sensor": "Q2", "scan": {"ranges": [0.7] * 4}})
    earlier = LookRecord(attempts=(Attempts(0, 1, 0),), std=SensorUncertainty(0.01, 0.02))
    before = after(state(), by_scan(state(looks=earlier.text()), scan(scenario)))
    assert record_of(before.looks).places
    updated = by_scan(before, scan_observation(scenario, far))
    assert updated.report is not None
    assert (updated.accepted, updated.report.reason) == (True, "nearest")
    assert updated.record == LookRecord(std=SensorUncertainty(0.01, 0.02), since=2)


def test_a_table_without_the_object_moves_absence_alone() -> None:
    ranges = {"P1": [0.5] * 4, "P2": [0.6] * 4, "P3": [0.7] * 4}
    scenario = core_scenario(absent=0.2, predictions={"Q1": ranges, "Q2": ranges})
    before = state(looks=LookRecord(log_odds_absent=math.log(0.25)).text())
    updated = by_scan(before, scan_observation(scenario, ScanRequest.model_validate(EMPTY)))
    assert updated.report is not None
    assert (updated.accepted, updated.report.reason) == (True, "nothing_seen")
    assert updated.belief is before.belief
    assert updated.record.log_odds_absent is not None
    assert updated.record.log_odds_absent > math.log(0.25)
    assert (updated.record.places, updated.place) == ((), None)


@pytest.mark.parametrize(("success", "weights"), [(True, [0.9, 0.1, 0.2]), (False, [0.1, 0.9, 0.8])])
def test_an_outcome_weighs_poses_by_the_scores_of_its_grasp(success: bool, weights: list[float]) -> None:
    request = OutcomeRequest(grasp="G1", success=success)
    updated = updated_by_outcome(state(), outcome_observation(core_scenario(), request))
    assert updated.belief.p.tolist() == pytest.approx([weight / sum(weights) for weight in weights])
    assert updated.report is not None
    assert (updated.report.beams_compared, updated.report.fit_rmsd_mm, updated.fit_rmsd_mm) == (0, None, 7.0)
    assert updated.record.attempts == (Attempts(0, int(success), int(not success)),)


def test_an_outcome_that_no_pose_allows_is_not_accepted_and_not_counted() -> None:
    scenario = core_scenario(scores={"probabilities": [[1.0] * 3, [0.5] * 3]})
    outcome = outcome_observation(scenario, OutcomeRequest(grasp="G1", success=False))
    updated = updated_by_outcome(state(), outcome)
    assert updated.report is not None
    assert (updated.accepted, updated.report.reason, updated.record) == (False, "no_match", LookRecord())


def test_an_object_that_may_have_moved_mixes_the_sessions_own_prior_and_forgets_looks() -> None:
    scenario = core_scenario(absent=0.2)
    prior, before = Belief.of([0.2, 0.3, 0.5]), Belief.of([0.0, 1.0, 0.0])
    viewpoint = viewpoint_of(scenario, AtPlace(sensor="Q1"))
    record = LookRecord((PlaceRecord(viewpoint, 1, 1),), log_odds_absent=3.0)
    moved = outcome_observation(scenario, OutcomeRequest(grasp="G1", success=True, object_moved=0.4))
    updated = updated_by_outcome(state(before, prior=prior, looks=record.text(), version=4), moved)
    assert updated.belief.p.tolist() == pytest.approx([0.08, 0.6 + 0.12, 0.2])
    assert updated.record == LookRecord(log_odds_absent=scenario.start.log_odds_absent, since=5)
