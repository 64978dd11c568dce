"""Updates of a session's belief: by a scan, by the outcome of a grasp, or by a stated belief."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

from voa_core.filtering import Belief
from voa_core.scenario import Scenario
from voa_core.updating import Update, update_estimate
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, UpdatedEstimate, UpdateRequest
from voa_service.failures import not_found
from voa_service.mapping.beliefs import belief_of, estimate_of
from voa_service.mapping.estimates import (
    absence_warnings,
    estimate_fields,
    session_message,
    summary_of,
    update_report,
    updated_session_message,
)
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.observations import ScanObservation, outcome_observation, scan_observation
from voa_service.mapping.under_way import announced_looks, stored_text, without_place
from voa_service.usecases.places import LookedFrom
from voa_service.usecases.sessions import Sessions, model_in_body
from voa_store.records import SessionChange, SessionState, StoredResponse, Write


@dataclass(frozen=True, eq=False)
class _Observation:
    """An observation of either kind, ready to be applied to a session's state.

    Attributes:
        kind: of the observation.
        scenario: of the session.
        update: returns the update of a state, and the record of looks and attempts after it.
        scan: the scan, already compared with every pose; None: the observation is an outcome.
    """

    kind: Literal["scan", "outcome"]
    scenario: Scenario
    update: Callable[[SessionState], tuple[Update, LookRecord]]
    scan: ScanObservation | None = None


@dataclass(frozen=True)
class Updates:
    """Use cases that change the belief of a session.

    An observation is compared with every pose before the transaction begins, because that does not depend on the
    belief: writers on one session wait for each other only while the result is applied.

    Attributes:
        sessions: use cases about whole sessions.
        places: use cases about the places that sessions were looked from.
        observed: called with the kind of each observation and its result: "accepted", or the reason of its refusal.
    """

    sessions: Sessions
    places: LookedFrom
    observed: Callable[[str, str], None]

    def apply_scan(self, id_: str, request: ScanRequest, write: Write) -> StoredResponse:
        """Update a session's belief by a raw scan.

        Raises:
            NotFound: there is no such session.
            VoaError: the scan does not fit the session's scenario.
            StoreError: the session has another version, or the idempotency key was used for another request.
        """
        state = self.sessions.store.get_session(id_)
        if state is None:
            return self._response_of_deleted(id_, write)
        scan = scan_observation(self.sessions.model_of(state).scenario, request)
        scan = self.places.prepared(state, scan)
        return self._observe(state, _Observation("scan", scan.scenario, partial(self._by_scan, scan), scan), write)

    def report_outcome(self, id_: str, request: OutcomeRequest, write: Write) -> StoredResponse:
        """Update a session's belief by the outcome of a grasp attempt.

        Raises:
            NotFound: there is no such session.
            UnknownName: the session's scenario has no such grasp.
            StoreError: the session has another version, or the idempotency key was used for another request.
        """
        state = self.sessions.store.get_session(id_)
        if state is None:
            return self._response_of_deleted(id_, write)
        outcome = outcome_observation(self.sessions.model_of(state).scenario, request)
        return self._observe(state, _Observation("outcome", outcome.scenario, outcome.updated), write)

    def put_belief(self, id_: str, request: BeliefRequest, write: Write) -> StoredResponse:
        """Replace a session's belief by the one in the request; null: by the session's prior.

        Raises:
            NotFound: there is no such session.
            VoaError: the numbers are not a belief over the scenario's poses.
            StoreError: the session has another version, or the idempotency key was used for another request.
        """
        sessions = self.sessions
        state = sessions.store.get_session(id_)
        if state is None:
            return self._response_of_deleted(id_, write)
        scenario, warnings = sessions.model_of(state).scenario, sessions.warnings(state.scenario)
        stated = None if request.belief is None else belief_of(request.belief, scenario)
        with sessions.store.change(id_, write) as change:
            before = change.state
            if before is not None:
                belief = before.prior if stated is None else stated
                record = record_of(before.looks).restarted(before.version + 1, scenario.start.log_odds_absent)
                after = self._next_version(before, scenario, belief, record, before.last_fit_rmsd_mm)
                message = session_message(scenario, after, warnings, after.updated_at)
                change.respond(StoredResponse(message.model_dump_json(), after.version), after)
        return self._committed(id_, change)

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update the belief in the request, or the scenario's prior where that is null, by a raw scan; stores nothing.

        Raises:
            UnknownReference: there is no such scenario.
            VoaError: the request does not fit the scenario.
        """
        scenario = model_in_body(self.sessions.models, request.scenario).scenario
        scan = scan_observation(scenario, request)
        result = update_estimate(estimate_of(request, scenario), scan.evidence, scenario.policy)
        absent = result.estimate.absent
        return UpdatedEstimate(
            **estimate_fields(scenario, result.belief, absent),
            scenario=request.scenario,
            version=None,
            last_fit_rmsd_mm=scan.evidence.fit_rmsd_mm if result.accepted else None,
            warnings=[*self.sessions.warnings(request.scenario), *scan.warnings, *absence_warnings(absent)],
            update=update_report(scenario, result, scan.evidence),
        )

    def _by_scan(self, scan: ScanObservation, state: SessionState) -> tuple[Update, LookRecord]:
        return self.places.updated(state, scan)

    def _observe(self, state: SessionState, observation: _Observation, write: Write) -> StoredResponse:
        """Apply an observation to a session, which gets a new version if the observation is accepted."""
        scan, scenario = observation.scan, observation.scenario
        warnings = [*self.sessions.warnings(state.scenario), *([] if scan is None else scan.warnings)]
        with self.sessions.store.change(state.id, write) as change:
            before = change.state
            if before is not None:
                result, record = observation.update(before)
                report = update_report(scenario, result, None if scan is None else scan.evidence)
                after = before
                if result.accepted:
                    fit = before.last_fit_rmsd_mm if scan is None else scan.evidence.fit_rmsd_mm
                    after = self._next_version(before, scenario, result.belief, record, fit)
                if scan is not None:
                    after = self._without_announcement(after, scan)
                message = updated_session_message(scenario, after, warnings, report, self.sessions.now())
                response = StoredResponse(message.model_dump_json(), after.version)
                change.respond(response, None if after is before else after, report.model_dump_json())
                self.observed(observation.kind, result.reason or "accepted")
        if scan is not None and change.after is not None and result.accepted and result.reason is None:
            self.places.keep(state.id, record, result.estimate.places[-1])
        return self._committed(state.id, change)

    def _without_announcement(self, state: SessionState, scan: ScanObservation) -> SessionState:
        """Return the state of a session without the announced looks that this scan ends."""
        if state.under_way is None:
            return state
        looks = announced_looks(state.under_way, self.sessions.now())
        left = without_place(looks, scan.scenario, scan.evidence.viewpoint)
        return replace(state, under_way=stored_text(left))

    def _next_version(
        self,
        state: SessionState,
        scenario: Scenario,
        belief: Belief,
        record: LookRecord,
        fit_rmsd_mm: float | None,
    ) -> SessionState:
        """Return the next version of a session, with another belief and record of looks."""
        return replace(
            state,
            version=state.version + 1,
            updated_at=self.sessions.now(),
            belief=belief,
            looks=record.text(),
            summary=summary_of(scenario, belief, record),
            last_fit_rmsd_mm=fit_rmsd_mm,
        )

    def _committed(self, id_: str, change: SessionChange) -> StoredResponse:
        """Publish a committed version, if there is a new one; returns the response to the write."""
        if change.after is not None and change.state is not None and change.after.version > change.state.version:
            self.sessions.committed(id_, change.after)
        return change.response

    def _response_of_deleted(self, id_: str, write: Write) -> StoredResponse:
        """Return the stored response to a write that was answered before its session was deleted.

        Raises:
            NotFound: there is no such session, and the write was not answered before.
        """
        response = None if write.key is None else self.sessions.store.get_response(write.key)
        if response is None:
            raise not_found("session", id_)
        return response
