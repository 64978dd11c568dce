"""Updates of a session's estimate by observations: from its stored state to the next belief, record and report."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.places import Place
from voa_core.updating import Update, update_estimate, update_estimate_by_outcome
from voa_msgs.sessions import BeliefRequest, UpdatedEstimate, UpdateReport, UpdateRequest
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.beliefs import belief_of, estimate_of
from voa_service.mapping.estimates import Summary, absence_warnings, absent_of, estimate_fields, update_report
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.models import Model
from voa_service.mapping.observations import OutcomeObservation, ScanObservation, scan_observation
from voa_store.records import SessionState

PlaceOf = Callable[[int, int], Place]
"""A function that returns a place of a session with the weights of its looks.

Its arguments are the index of the place in the session's record, and the number J of displaced copies of each pose.
"""


@dataclass(frozen=True, eq=False)
class Updated:
    """Result of an observation, or of a belief that replaces the session's.

    Attributes:
        belief: after it.
        record: of looks and attempts after it.
        report: of an observation; None: the belief was replaced.
        fit_rmsd_mm: fit of the newest accepted scan, millimetres; None: there is none.
        place: from which an accepted look was taken, with the look; None: the looks of places are as before.
    """

    belief: Belief
    record: LookRecord
    report: UpdateReport | None
    fit_rmsd_mm: float | None
    place: Place | None = None

    @property
    def accepted(self) -> bool:
        """True if the session gets a new version."""
        return self.report is None or self.report.accepted


def next_version(state: SessionState, updated: Updated, summary: Summary, now: datetime) -> SessionState:
    """Return the next version of a session.

    Args:
        state: of the session before.
        updated: by an accepted observation, or by another belief.
        summary: of the estimate after it.
        now: time of the new version.
    """
    return replace(
        state,
        version=state.version + 1,
        updated_at=now,
        belief=updated.belief,
        looks=updated.record.text(),
        summary=json.dumps(summary),
        last_fit_rmsd_mm=updated.fit_rmsd_mm,
    )


def updated_by_scan(state: SessionState, scan: ScanObservation, place_of: PlaceOf) -> Updated:
    """Update a session's estimate by a scan.

    Where look and place have different numbers of displaced copies, those with fewer are compared again with more.

    Args:
        state: of the session.
        scan: compared with the poses of the session's scenario.
        place_of: returns the place that the scan shares with earlier looks.
    """
    record, version = record_of(state.looks), state.version + 1
    scan, before = with_place(state, scan, place_of)
    result = update_estimate(before, scan.evidence, scan.scenario.policy, version)
    report = update_report(scan.scenario, result, scan.evidence)
    if not result.accepted:
        return Updated(state.belief, record, report, state.last_fit_rmsd_mm)
    fit, log_odds = scan.evidence.fit_rmsd_mm, result.estimate.log_odds_absent
    record = replace(record, std=record.std if scan.received.listed else scan.received.std)
    if result.reason == "nearest":
        return Updated(result.belief, record.restarted(version, log_odds), report, fit)
    if result.reason is not None:  # the scan moves the odds of absence alone
        return Updated(state.belief, replace(record, log_odds_absent=_moved(record, before, log_odds)), report, fit)
    place = result.estimate.places[-1]
    index = record.index_of(scan.evidence.viewpoint)
    return Updated(result.belief, record.with_look(index, place, log_odds), report, fit, place)


def with_place(state: SessionState, scan: ScanObservation, place_of: PlaceOf) -> tuple[ScanObservation, Estimate]:
    """Return a scan and a session's estimate with the place of the scan, both with as many displaced copies."""
    record = record_of(state.looks)
    index = record.index_of(scan.evidence.viewpoint)
    if index is None:
        return scan, record.estimate(state.belief)
    known = record.places[index]
    scan = scan.with_copies(known.copies)
    copies = scan.evidence.copies
    if known.copies == copies == 1:  # each look counts by itself: the weights of earlier ones are not needed
        alike = Place(known.viewpoint, tuple(range(known.looks)), np.zeros((len(state.belief.p), 1)))
        return scan, record.estimate(state.belief, alike)
    estimate = record.estimate(state.belief, place_of(index, known.copies))
    return scan, estimate.with_more_copies(0, place_of(index, copies)) if 1 < known.copies < copies else estimate


def _moved(record: LookRecord, before: Estimate, after: float | None) -> float | None:
    """Move the log odds of a record by as much as a scan has moved those of the estimate made from it."""
    if record.log_odds_absent is None or before.log_odds_absent is None or after is None:
        return after
    same = record.log_odds_absent == before.log_odds_absent
    return after if same else record.log_odds_absent + (after - before.log_odds_absent)


def updated_by_outcome(state: SessionState, outcome: OutcomeObservation) -> Updated:
    """Update a session's estimate by the outcome of a grasp attempt."""
    scenario, record = outcome.scenario, record_of(state.looks)
    result = update_estimate_by_outcome(
        record.estimate(state.belief),
        scenario.table,
        outcome.grasp,
        outcome.success,
        scenario.policy,
        object_moved=outcome.object_moved,
        start=Estimate.of(state.prior, scenario.absent),
    )
    if not result.accepted:
        after = record
    elif outcome.object_moved > 0.0:
        after = record.restarted(state.version + 1, result.estimate.log_odds_absent)
    else:
        after = replace(record, attempts=result.estimate.attempts)
    return Updated(result.belief, after, update_report(scenario, result), state.last_fit_rmsd_mm)


def replaced_belief(state: SessionState, model: Model, request: BeliefRequest) -> Updated:
    """Replace a session's belief by the one in a request; null: by the session's prior.

    Raises:
        InvalidInput: the numbers are not a belief over the scenario's poses.
    """
    scenario = model.scenario
    belief = state.prior if request.belief is None else belief_of(request.belief, scenario)
    record = record_of(state.looks).restarted(state.version + 1, scenario.start.log_odds_absent)
    return Updated(belief, record, None, state.last_fit_rmsd_mm)


def updated_once(model: Model, request: UpdateRequest, warnings: list[ProbableMistake]) -> UpdatedEstimate:
    """Update the estimate that a request states by the scan in it, as a message.

    Args:
        model: of the scenario.
        request: with the belief and the scan.
        warnings: about the scenario.

    Raises:
        VoaError: the request does not fit the scenario.
    """
    scenario = model.scenario
    scan = scan_observation(scenario, request)
    result: Update = update_estimate(estimate_of(request, scenario), scan.evidence, scenario.policy)
    absent = absent_of(result.estimate)
    return UpdatedEstimate(
        **estimate_fields(scenario, result.belief, absent),
        scenario=request.scenario,
        version=None,
        last_fit_rmsd_mm=scan.evidence.fit_rmsd_mm if result.accepted else None,
        warnings=[*warnings, *scan.warnings, *absence_warnings(absent)],
        update=update_report(scenario, result, scan.evidence),
    )
