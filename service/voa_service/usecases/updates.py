"""Updates of a session's belief: by a scan, by the outcome of a grasp, or by a stated belief."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, UpdatedEstimate, UpdateRequest
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import not_found
from voa_service.mapping.beliefs import belief_of
from voa_service.mapping.estimates import estimate_fields, session_message, summary_of, updated_session_message
from voa_service.mapping.observations import Observation, UpdatedBelief, outcome_observation, scan_observation
from voa_service.usecases.sessions import Sessions, model_in_body
from voa_store.records import SessionChange, SessionState, StoredResponse, Write


@dataclass(frozen=True)
class Updates:
    """Use cases that change the belief of a session.

    An observation is compared with every pose before the transaction begins, because that does not depend on the
    belief: writers on one session wait for each other only while the result is applied.

    Attributes:
        sessions: use cases about whole sessions.
        observed: called with the kind of each observation and its result: "accepted", or the reason of its refusal.
    """

    sessions: Sessions
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
        return self._observe(state, scan_observation(self.sessions.model_of(state).scenario, request), write)

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
        return self._observe(state, outcome_observation(self.sessions.model_of(state).scenario, request), write)

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
            if change.state is not None:
                belief = change.state.prior if stated is None else stated
                after = self._next_version(change.state, belief=belief, summary=summary_of(scenario, belief))
                message = session_message(scenario, after, warnings)
                change.respond(StoredResponse(message.model_dump_json(), after.version), after)
        return self._committed(id_, change)

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update the belief in the request, or the scenario's prior where that is null, by a raw scan; stores nothing.

        Raises:
            UnknownReference: there is no such scenario.
            VoaError: the request does not fit the scenario.
        """
        scenario = model_in_body(self.sessions.models, request.scenario).scenario
        observation = scan_observation(scenario, request)
        updated = observation.applied_to(belief_of(request.belief, scenario))
        return UpdatedEstimate(
            **estimate_fields(scenario, updated.belief),
            scenario=request.scenario,
            version=None,
            last_fit_rmsd_mm=observation.fit_rmsd_mm(None) if updated.report.accepted else None,
            warnings=[*self.sessions.warnings(request.scenario), *observation.warnings],
            update=updated.report,
        )

    def _observe(self, state: SessionState, observation: Observation, write: Write) -> StoredResponse:
        """Apply an observation to a session, which gets a new version if the observation is accepted."""
        warnings = [*self.sessions.warnings(state.scenario), *observation.warnings]
        with self.sessions.store.change(state.id, write) as change:
            if change.state is not None:
                updated = observation.applied_to(change.state.belief)
                self._respond(change, change.state, observation, updated, warnings)
                self.observed(observation.kind, updated.report.reason or "accepted")
        return self._committed(state.id, change)

    def _respond(
        self,
        change: SessionChange,
        before: SessionState,
        observation: Observation,
        updated: UpdatedBelief,
        warnings: Sequence[ProbableMistake],
    ) -> None:
        report, after = updated.report, None
        if report.accepted:
            fit = observation.fit_rmsd_mm(before.last_fit_rmsd_mm)
            summary = summary_of(observation.scenario, updated.belief)
            after = self._next_version(before, belief=updated.belief, last_fit_rmsd_mm=fit, summary=summary)
        state = after or before
        message = updated_session_message(observation.scenario, state, warnings, report)
        response = StoredResponse(message.model_dump_json(), state.version)
        change.respond(response, after, report.model_dump_json())

    def _next_version(self, state: SessionState, **changes: Any) -> SessionState:
        return replace(state, version=state.version + 1, updated_at=self.sessions.now(), **changes)

    def _committed(self, id_: str, change: SessionChange) -> StoredResponse:
        """Publish a committed change, if there is one; returns the response to the write."""
        if change.after is not None:
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
