"""What a belief means in messages: estimates and the reports of updates."""

from typing import Any

from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.scenario import Scenario
from voa_core.updating import Update
from voa_msgs.sessions import UpdateReport
from voa_service.ports import SessionState


def estimate_fields(scenario: Scenario, belief: Belief) -> dict[str, Any]:
    """The fields of `sessions.Estimate` that follow from a belief."""
    choice = best_grasp(scenario.table, belief.p)
    return {
        "poses": list(scenario.poses.names),
        "belief": belief.p.tolist(),
        "best_grasp": None if choice.index is None else scenario.table.names[choice.index],
        "expected_score": choice.expected_score,
        "entropy_nats": belief.entropy_nats,
    }


def session_fields(state: SessionState, scenario: Scenario) -> dict[str, Any]:
    """The fields of `sessions.Session`, but for its warnings."""
    return estimate_fields(scenario, state.belief) | {
        "id": state.id,
        "scenario": state.scenario,
        "version": state.version,
        "last_fit_rmsd_mm": state.last_fit_rmsd_mm,
        "created_at": state.created_at,
        "updated_at": state.updated_at,
    }


def report_of(scenario: Scenario, update: Update, evidence: Evidence | None = None) -> UpdateReport:
    """What an observation did; a grasp's outcome has no `evidence` of beams."""
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
