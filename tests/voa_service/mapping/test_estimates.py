"""Estimates as messages: the belief with its best grasp, and the report on an update."""

import json
import math
from datetime import UTC, datetime

import pytest

from tests.support.scenarios import core_scenario
from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.updating import Update
from voa_service.mapping.estimates import (
    belief_summary,
    estimate_fields,
    session_message,
    summary_of,
    update_report,
    updated_session_message,
)
from voa_store.records import SessionState

HALVES = Belief.of([0.5, 0.5, 0.0])
NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
REFUSED = Update(Estimate.of(HALVES), accepted=False, reason="no_beams", log_evidence=None)


def state(belief: Belief) -> SessionState:
    return SessionState("S", "scenario", 3, belief, belief, 1.5, NOON, NOON.replace(hour=13), "{}")


def test_a_belief_is_summarised_by_its_best_grasp_and_its_entropy() -> None:
    summary = belief_summary(core_scenario(), HALVES)
    assert summary == {"best_grasp": "G1", "expected_score": 0.5, "entropy_nats": pytest.approx(math.log(2.0))}
    assert json.loads(summary_of(core_scenario(), HALVES)) == summary


def test_a_table_of_failures_has_no_best_grasp() -> None:
    hopeless = core_scenario(scores={"probabilities": [[0.0] * 3] * 2})
    assert belief_summary(hopeless, HALVES)["best_grasp"] is None


def test_an_estimate_names_the_poses_in_the_order_of_its_belief() -> None:
    fields = estimate_fields(core_scenario(), HALVES)
    assert (fields["poses"], fields["belief"]) == (["P1", "P2", "P3"], [0.5, 0.5, 0.0])


def test_a_session_has_every_fact_of_its_state() -> None:
    message = session_message(core_scenario(), state(HALVES), [])
    assert (message.id, message.scenario, message.version, message.last_fit_rmsd_mm) == ("S", "scenario", 3, 1.5)
    assert (message.created_at, message.updated_at) == (NOON, NOON.replace(hour=13))
    report = update_report(core_scenario(), REFUSED)
    updated = updated_session_message(core_scenario(), state(HALVES), [], report)
    assert updated.update == report
    assert updated.model_dump(exclude={"update"}) == message.model_dump()


def test_a_report_without_a_compared_beam_has_no_fit() -> None:
    report = update_report(core_scenario(), REFUSED)
    assert (report.accepted, report.reason, report.beams_compared) == (False, "no_beams", 0)
    assert {report.fit_rmsd_mm, report.fit_hit_rmsd_mm, report.best_fit_pose, report.log_evidence} == {None}
