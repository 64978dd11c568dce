"""Estimates: from beliefs and updates to messages."""

import json
from collections.abc import Sequence
from typing import Any

from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.scenario import Scenario
from voa_core.updating import Update
from voa_msgs.sessions import Session, UpdatedSession, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_store.records import SessionState


def belief_summary(scenario: Scenario, belief: Belief) -> dict[str, Any]:
    """Return the fields of a message that summarise a belief: best grasp, its expected score, entropy in nats."""
    choice = best_grasp(scenario.table, belief.p)
    return {
        "best_grasp": None if choice.index is None else scenario.table.names[choice.index],
        "expected_score": choice.expected_score,
        "entropy_nats": belief.entropy_nats,
    }


def summary_of(scenario: Scenario, belief: Belief) -> str:
    """Return the summary of a belief that is stored with a session for lists, as JSON."""
    return json.dumps(belief_summary(scenario, belief))


def estimate_fields(scenario: Scenario, belief: Belief) -> dict[str, Any]:
    """Return the fields of `voa_msgs.sessions.Estimate` that follow from a belief over n poses."""
    beliefs = {"poses": list(scenario.poses.names), "belief": belief.p.tolist()}
    return beliefs | belief_summary(scenario, belief)


def session_message(scenario: Scenario, state: SessionState, warnings: Sequence[ProbableMistake]) -> Session:
    """Convert a session's state to a message."""
    return Session(**_session_fields(scenario, state), warnings=list(warnings))


def updated_session_message(
    scenario: Scenario, state: SessionState, warnings: Sequence[ProbableMistake], report: UpdateReport
) -> UpdatedSession:
    """Convert a session's state after an observation to a message, with the report of the update."""
    return UpdatedSession(**_session_fields(scenario, state), warnings=list(warnings), update=report)


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


def _session_fields(scenario: Scenario, state: SessionState) -> dict[str, Any]:
    return estimate_fields(scenario, state.belief) | {
        "id": state.id,
        "scenario": state.scenario,
        "version": state.version,
        "last_fit_rmsd_mm": state.last_fit_rmsd_mm,
        "created_at": state.created_at,
        "updated_at": state.updated_at,
    }
