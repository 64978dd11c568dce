"""Updates of a session's belief: by a scan, by the outcome of a grasp, or by a stated belief."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

from voa_msgs.sessions import BeliefRequest, OutcomeRequest, Scan, ScanRequest, UpdatedEstimate, UpdateRequest
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import not_found
from voa_service.mapping.estimates import absent_of, belief_summary, session_message
from voa_service.mapping.models import Model
from voa_service.mapping.observations import (
    ScanObservation,
    TakesLong,
    outcome_observation,
    received_scan,
    scan_observation,
)
from voa_service.mapping.under_way import without_announcement
from voa_service.mapping.updates import Updated, next_version, replaced_belief, updated_by_outcome, updated_once
from voa_service.usecases.places import LookedFrom
from voa_service.usecases.sessions import Sessions, model_in_body
from voa_store.errors import SessionMissing
from voa_store.records import SessionChange, SessionState, StoredResponse, Write

_MOST_REHEARSED = 2_000
"""Most poses of a session that `rehearse` updates: 2 000 poses of a mesh take about half a second."""


class AttemptCounter(Protocol):
    """Port to the counter of grasp attempts."""

    def __call__(self, promised: float, *, success: bool) -> None:
        """Count an attempt by its expected score before the outcome, 0 to 1, and by success."""


@dataclass(frozen=True)
class Updates:
    """Use cases that change the belief of a session.

    A scan is compared with every pose before the transaction begins, because that does not depend on the belief:
    writers on one session wait for each other only while the result is applied. A scan that is compared in a moment is
    compared within the transaction instead, once the scans of the poses are predicted: one thread does that for all
    writers of a group, while the others sleep. Many threads that compute at once would pass the interpreter's lock from
    one to the next for about as long as the work itself takes.

    Attributes:
        sessions: use cases about whole sessions.
        places: use cases about the places that sessions were looked from.
        observed: called with the kind of each observation and its result: "accepted", or the reason of its refusal.
        attempted: called for each outcome that is not a repetition.
    """

    sessions: Sessions
    places: LookedFrom
    observed: Callable[[str, str], None]
    attempted: AttemptCounter

    def apply_scan(self, id_: str, request: ScanRequest, write: Write) -> StoredResponse:
        """Update a session's belief by a raw scan.

        Raises:
            NotFound: there is no such session.
            VoaError: the scan does not fit the session's scenario.
            StoreError: the session has another version, or the idempotency key was used for another request.
        """
        state = self.places.last_state(id_)
        if state is None:
            return self._response_of_deleted(id_, write)
        model = self.sessions.model_of(state)
        received = received_scan(model.scenario, request)
        try:
            if received.is_quick:
                received = received.predicted()
                with suppress(TakesLong):
                    return self._apply(state, model, write, partial(received.observation, quickly=True))
            scan = self.places.prepared(state, received.observation())
            return self._apply(state, model, write, lambda: scan)
        except SessionMissing:  # since this process saw it
            return self._response_of_deleted(id_, write)

    def _apply(
        self, state: SessionState, model: Model, write: Write, observe: Callable[[], ScanObservation]
    ) -> StoredResponse:
        """Update a session's belief by the scan that `observe` returns within the transaction, compared by then."""

        def update(before: SessionState) -> tuple[Updated, ScanObservation]:
            scan = observe()
            return self.places.updated(before, scan), scan

        response, updated = self._change(state, model, write, update)
        if updated is not None:
            self.places.keep(state.id, updated)
        return response

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
        model = self.sessions.model_of(state)
        outcome = outcome_observation(model.scenario, request)
        response, updated = self._change(
            state, model, write, lambda before: (updated_by_outcome(before, outcome), None)
        )
        if updated is not None:
            self.attempted(outcome.promised(state.belief), success=outcome.success)
        return response

    def put_belief(self, id_: str, request: BeliefRequest, write: Write) -> StoredResponse:
        """Replace a session's belief by the one in the request; null: by the session's prior.

        Raises:
            NotFound: there is no such session.
            VoaError: the numbers are not a belief over the scenario's poses.
            StoreError: the session has another version, or the idempotency key was used for another request.
        """
        state = self.sessions.store.get_session(id_)
        if state is None:
            return self._response_of_deleted(id_, write)
        model = self.sessions.model_of(state)
        replaced_belief(state, model, request)  # a wrong belief is refused before the transaction
        return self._change(state, model, write, lambda before: (replaced_belief(before, model, request), None))[0]

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update the belief in the request, or the scenario's prior where that is null, by a raw scan; stores nothing.

        Raises:
            UnknownReference: there is no such scenario.
            VoaError: the request does not fit the scenario.
        """
        model = model_in_body(self.sessions.models, request.scenario)
        return updated_once(model, request, [*self.sessions.models.warnings(request.scenario)])

    def rehearse(self) -> None:
        """Update the session that was opened last by a scan, as if it had no looks yet, and discard the result.

        What an update uses is then loaded: the next scan of that session need not wait for its scenario to be read.
        Sessions with very many poses are left out, because a start would wait long for them.
        """
        newest = self.sessions.store.newest_session()
        if newest is None or len(newest.belief.p) > _MOST_REHEARSED:
            return
        self.places.keep_state(newest)
        state = replace(newest, looks=None)  # earlier looks would be compared again, however many they are
        model = self.sessions.model_of(state)
        scenario = model.scenario
        lidar = scenario.lidar
        ranges: list[float | None] = [0.5 * (lidar.range_min + lidar.range_max)] * lidar.grid.beams
        request = ScanRequest(sensor=scenario.sensors[0].name, scan=Scan(ranges=ranges))
        scan = self.places.prepared(state, scan_observation(scenario, request))
        known = [*self.sessions.models.warnings(state.scenario)]
        self._answer(SessionChange(state), model, state, self.places.updated(state, scan), scan, known)

    def _change(
        self,
        state: SessionState,
        model: Model,
        write: Write,
        update: Callable[[SessionState], tuple[Updated, ScanObservation | None]],
    ) -> tuple[StoredResponse, Updated | None]:
        """Change a session's estimate; the session gets a new version if the change is accepted.

        Args:
            state: of the session, as it was read before the transaction.
            model: of its scenario.
            write: the request.
            update: computes the result from the state within the transaction; returns it with the scan that changes the
                estimate, or None where it is an outcome or another belief.

        Returns:
            The response to the write, and the result; None: the write was answered before.
        """
        updated: Updated | None = None
        known = [*self.sessions.models.warnings(state.scenario)]  # which take long the first time

        def step(change: SessionChange, before: SessionState) -> None:
            nonlocal updated
            updated, scan = update(before)
            self._answer(change, model, before, updated, scan, known)

        change = self.sessions.store.change(state.id, write, step)
        if updated is not None and updated.report is not None:
            self.observed(write.kind, updated.report.reason or "accepted")
        return self._committed(state.id, change), updated

    def _answer(
        self,
        change: SessionChange,
        model: Model,
        before: SessionState,
        updated: Updated,
        scan: ScanObservation | None,
        known: list[ProbableMistake],
    ) -> None:
        """Respond to a change with the state that its result makes of the state before.

        Args:
            change: to respond to.
            model: of the session's scenario.
            before: state of the session.
            updated: result of the change.
            scan: that changes the estimate; None: an outcome does, or another belief.
            known: probable mistakes in the scenario.
        """
        now, report = self.sessions.now(), updated.report
        summary = belief_summary(model.scenario, updated.belief, absent_of(updated.record))
        after = next_version(before, updated, summary, now) if updated.accepted else before
        warnings = known
        if scan is not None:
            warnings = known + scan.warnings
            after = without_announcement(after, scan, now)
        body = session_message(model.scenario, after, warnings, now, report, summary).model_dump_json()
        text = None if report is None else report.model_dump_json()
        change.respond(StoredResponse(body, after.version), None if after is before else after, text)

    def _committed(self, id_: str, change: SessionChange) -> StoredResponse:
        """Publish a committed version, if there is a new one; returns the response to the write."""
        if change.after is not None and change.state is not None and change.after.version > change.state.version:
            self.places.keep_state(change.after)
            self.sessions.committed(id_, change.after)
        return change.response

    def _response_of_deleted(self, id_: str, write: Write) -> StoredResponse:
        """Return the stored response to a write of a session that is deleted; responses are removed with the session.

        Raises:
            NotFound: there is no such session, and no response is left.
            KeyReused: the key is that of the deletion.
        """
        response = None if write.key is None else self.sessions.store.get_response(write.key)
        if response is None:
            raise not_found("session", id_)
        return response
