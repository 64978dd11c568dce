"""Estimates: from beliefs and updates to messages."""

import json
from collections.abc import Sequence
from datetime import datetime
from typing import Any

from voa_core.absence import probability_of
from voa_core.estimates import Estimate
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.scenario import Scenario
from voa_core.updating import Update
from voa_msgs.sessions import Session, UpdatedSession, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.looks import LookRecord, place_messages, record_of
from voa_service.mapping.under_way import announced_looks
from voa_store.records import SessionState

Summary = dict[str, Any]
"""The fields of a message that summarise an estimate: best grasp, its expected score, entropy, absence."""

ABSENT = 0.5
"""Probability of absence above which a warning says that the object is probably not there."""


def belief_summary(scenario: Scenario, belief: Belief, absent: float | None) -> Summary:
    """Summarise an estimate."""
    choice = best_grasp(scenario.table, belief.p)
    return {
        "best_grasp": None if choice.index is None else scenario.table.names[choice.index],
        "expected_score": choice.expected_score,
        "entropy_nats": belief.entropy_nats,
        "absent": absent,
    }


def summary_of(scenario: Scenario, belief: Belief, record: LookRecord) -> str:
    """Return the summary of an estimate that is stored with a session for lists, as JSON."""
    return json.dumps(belief_summary(scenario, belief, absent_of(record)))


def absent_of(state: LookRecord | Estimate) -> float | None:
    """Return the probability that the object lies at none of the poses; None: that it lies at one is certain."""
    if state.log_odds_absent is None:
        return None
    return float(f"{probability_of(state.log_odds_absent):.15g}")  # 0.05 is 0.05 again


def absence_warnings(absent: float | None) -> list[ProbableMistake]:
    """Return a warning where the object probably lies at none of the poses."""
    if absent is None or absent <= ABSENT:
        return []
    detail = (
        f"the object probably lies at none of the poses (absent = {absent:.3g}): belief and expected scores hold only "
        "if it lies at one of them; look again, or put the object back, before a grasp is tried"
    )
    return [ProbableMistake(kind="probably-absent", detail=detail)]


def estimate_fields(scenario: Scenario, belief: Belief, absent: float | None) -> dict[str, Any]:
    """Return the fields of `voa_msgs.sessions.Estimate` that follow from a belief over n poses, and from absence."""
    return _belief_fields(scenario, belief) | belief_summary(scenario, belief, absent)


def _belief_fields(scenario: Scenario, belief: Belief) -> dict[str, Any]:
    return {"poses": list(scenario.poses.names), "belief": belief.p.tolist()}


def session_message(
    scenario: Scenario,
    state: SessionState,
    warnings: Sequence[ProbableMistake],
    now: datetime,
    report: UpdateReport | None = None,
    summary: Summary | None = None,
) -> Session:
    """Convert a session's state to a message.

    Args:
        scenario: of the session.
        state: of the session.
        warnings: about the scenario and the scan.
        now: announced looks that have expired by then are left out.
        report: of the observation that the message answers; None: it answers another request.
        summary: of the session's estimate; None: it is computed.
    """
    record = record_of(state.looks)
    absent = absent_of(record)
    summary = belief_summary(scenario, state.belief, absent) if summary is None else summary
    fields = (
        _belief_fields(scenario, state.belief)
        | summary
        | {
            "id": state.id,
            "scenario": state.scenario,
            "version": state.version,
            "last_fit_rmsd_mm": state.last_fit_rmsd_mm,
            "created_at": state.created_at,
            "updated_at": state.updated_at,
            "places": place_messages(record.places),
            "under_way": announced_looks(state.under_way, now),
            "warnings": [*warnings, *absence_warnings(absent)],
        }
    )
    return Session(**fields) if report is None else UpdatedSession(**fields, update=report)


def update_report(scenario: Scenario, update: Update, evidence: Evidence | None = None) -> UpdateReport:
    """Convert the result of an update to a message.

    Args:
        scenario: of the session.
        update: accepted or not.
        evidence: of a scan's beams; None: the observation is a grasp's outcome.
    """
    compared = 0 if evidence is None else evidence.beams_compared
    fitted = evidence if compared else None
    return UpdateReport(
        accepted=update.accepted,
        reason=update.reason,
        log_evidence=update.log_evidence,
        fit_rmsd_mm=fitted.fit_rmsd_mm if fitted else None,
        fit_hit_rmsd_mm=fitted.fit_hit_rmsd_mm if fitted else None,
        best_fit_pose=scenario.poses.names[fitted.best_fit] if fitted else None,
        beams_compared=compared,
    )
