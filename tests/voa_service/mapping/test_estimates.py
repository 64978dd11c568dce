"""Estimates as messages: the belief with its best grasp, and the report on an update."""

import json
import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from tests.support.scenarios import core_scenario
from voa_core.absence import log_odds_of
from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.places import Viewpoint
from voa_core.updating import Update
from voa_msgs.looks import LookAnnouncement
from voa_msgs.sessions import UpdatedSession
from voa_service.mapping.estimates import (
    absence_warnings,
    absent_of,
    belief_summary,
    estimate_fields,
    session_message,
    summary_of,
    update_report,
)
from voa_service.mapping.looks import LookRecord, PlaceRecord
from voa_service.mapping.under_way import LASTS, announced, stored_text
from voa_store.records import SessionState

HALVES = Belief.of([0.5, 0.5, 0.0])
NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
REFUSED = Update(Estimate.of(HALVES), accepted=False, reason="no_beams", log_evidence=None)
RECORD = LookRecord((PlaceRecord(Viewpoint("Q1", 0.0, 0.0, 0.0, None), 2, 1),), log_odds_absent=log_odds_of(0.25))


def state(belief: Belief, record: LookRecord | None = None) -> SessionState:
    text = None if record is None else record.text()
    return SessionState("S", "scenario", 3, belief, belief, 1.5, NOON, NOON.replace(hour=13), "{}", text)


def test_a_belief_is_summarised_by_its_best_grasp_its_entropy_and_absence() -> None:
    entropy = pytest.approx(math.log(2.0))
    summary = belief_summary(core_scenario(), HALVES, None)
    assert summary == {"best_grasp": "G1", "expected_score": 0.5, "entropy_nats": entropy, "absent": None}
    assert json.loads(summary_of(core_scenario(), HALVES, LookRecord())) == summary
    assert json.loads(summary_of(core_scenario(), HALVES, RECORD))["absent"] == pytest.approx(0.25)


def test_a_table_of_failures_has_no_best_grasp() -> None:
    hopeless = core_scenario(scores={"probabilities": [[0.0] * 3] * 2})
    assert belief_summary(hopeless, HALVES, None)["best_grasp"] is None


def test_an_estimate_names_the_poses_in_the_order_of_its_belief() -> None:
    fields = estimate_fields(core_scenario(), HALVES, 0.5)
    assert (fields["poses"], fields["belief"], fields["absent"]) == (["P1", "P2", "P3"], [0.5, 0.5, 0.0], 0.5)


def test_a_session_has_every_fact_of_its_state() -> None:
    message = session_message(core_scenario(), state(HALVES), [], NOON)
    assert (message.id, message.scenario, message.version, message.last_fit_rmsd_mm) == ("S", "scenario", 3, 1.5)
    assert (message.created_at, message.updated_at) == (NOON, NOON.replace(hour=13))
    assert (message.places, message.under_way, message.absent, message.warnings) == ([], [], None, [])
    report = update_report(core_scenario(), REFUSED)
    updated = session_message(core_scenario(), state(HALVES), [], NOON, report)
    assert isinstance(updated, UpdatedSession)
    assert updated.update == report
    assert updated.model_dump(exclude={"update"}) == message.model_dump()


def test_a_session_shows_its_places_its_absence_and_the_looks_under_way() -> None:
    look = announced("L", LookAnnouncement(sensor="Q2"), NOON)
    own = replace(state(HALVES, RECORD), under_way=stored_text([look]))
    message = session_message(core_scenario(), own, [], NOON + LASTS - timedelta(seconds=1))
    assert [(place.sensor, place.looks) for place in message.places] == [("Q1", 2)]
    assert message.absent == pytest.approx(0.25)
    assert message.under_way == [look]
    assert session_message(core_scenario(), own, [], NOON + LASTS).under_way == []


@pytest.mark.parametrize(("absent", "warns"), [(None, False), (0.5, False), (0.5000001, True), (1.0, True)])
def test_absence_above_one_half_is_a_warning(absent: float | None, warns: bool) -> None:
    warnings = absence_warnings(absent)
    assert [warning.kind for warning in warnings] == ["probably-absent"] * warns
    if warns:
        record = LookRecord(log_odds_absent=math.inf if absent == 1.0 else log_odds_of(absent or 0.0))
        message = session_message(core_scenario(), state(HALVES, record), [], NOON)
        assert [warning.kind for warning in message.warnings] == ["probably-absent"]


def test_certain_absence_is_a_probability() -> None:
    assert absent_of(LookRecord(log_odds_absent=math.inf)) == 1.0
    assert absent_of(LookRecord(log_odds_absent=-math.inf)) == 0.0


def test_a_report_without_a_compared_beam_has_no_fit() -> None:
    report = update_report(core_scenario(), REFUSED)
    assert (report.accepted, report.reason, report.beams_compared) == (False, "no_beams", 0)
    assert {report.fit_rmsd_mm, report.fit_hit_rmsd_mm, report.best_fit_pose, report.log_evidence} == {None}
