"""Replays stored histories through the production's updates, without a store."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from tests.simulation.replica import UseCases
from voa_core.filtering import Belief
from voa_core.places import Place
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest
from voa_service.mapping.estimates import absent_of, belief_summary
from voa_service.mapping.models import Model
from voa_service.mapping.observations import ScanObservation, outcome_observation, scan_observation
from voa_service.mapping.updates import Updated, next_version, replaced_belief, updated_by_outcome, updated_by_scan
from voa_store.records import HistoryEntry, SessionState


def replayed(inside: UseCases, entries: Sequence[HistoryEntry]) -> list[Belief]:
    """Return the belief at each version of a history, from its prior and its requests alone."""
    state = replace(entries[0].state, belief=entries[0].state.prior)
    model = inside.sessions.model_of(state)
    beliefs = [state.belief]
    for entry in entries[1:]:
        updated = _updated(model, state, entry)
        summary = belief_summary(model.scenario, updated.belief, absent_of(updated.record))
        state = next_version(state, updated, summary, entry.state.updated_at)
        beliefs.append(state.belief)
    return beliefs


def _updated(model: Model, state: SessionState, entry: HistoryEntry) -> Updated:
    match entry.kind:
        case "scan":
            return updated_by_scan(state, _scan(model, entry.request), _no_place)
        case "outcome":
            outcome = outcome_observation(model.scenario, OutcomeRequest.model_validate_json(entry.request))
            return updated_by_outcome(state, outcome)
        case _:
            return replaced_belief(state, model, BeliefRequest.model_validate_json(entry.request))


@lru_cache(maxsize=4096)
def _scan(model: Model, request: str) -> ScanObservation:
    """Compare a scan with the poses, which does not depend on the session."""
    return scan_observation(model.scenario, ScanRequest.model_validate_json(request))


def _no_place(index: int, copies: int) -> Place:
    raise RuntimeError("scenarios of the simulation have no spread: each look counts by itself")
