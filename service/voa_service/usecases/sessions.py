"""Sessions: open one, send scans, read what is believed."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from voa_core.errors import UnknownName, VoaError
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp, log_outcome_weights
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.scenario import Scenario
from voa_core.updating import Update, update, update_by_outcome
from voa_msgs.sessions import (
    BeliefRequest,
    HistoryPage,
    OutcomeRequest,
    ScanRequest,
    Session,
    SessionPage,
    SessionRequest,
    SessionSummary,
    UpdatedEstimate,
    UpdatedSession,
    UpdateReport,
    UpdateRequest,
)
from voa_msgs.sessions import HistoryEntry as HistoryEntryMessage
from voa_msgs.warnings import ProbableMistake
from voa_service.failures import UnknownReference, not_found, of_core
from voa_service.mapping.models import Models
from voa_service.mapping.scenarios import place_of, prior_of, scan_of, warning_messages
from voa_service.ports import (
    Answered,
    Clock,
    HistoryEntry,
    IdempotencyKey,
    IdSource,
    ListedSession,
    RobotLook,
    SessionState,
    Step,
    Store,
    Write,
)
from voa_service.runtime.cache import Cache
from voa_service.usecases.estimates import estimate_fields, report_of, session_fields
from voa_service.usecases.pages import page, position


@dataclass(frozen=True)
class _Told(Answered):
    @property
    def nbytes(self) -> int:
        return len(self.body)


@dataclass(frozen=True)
class Sessions:
    """Everything about sessions and scans."""

    store: Store
    models: Models
    now: Clock
    new_id: IdSource
    told: Cache
    """Answers about a session, by when it moved last."""
    committed: Callable[[str, SessionState | None], None]
    """Told after each commit: the session as it is then; None: it is gone."""
    observed: Callable[[str, str], None]
    """Told the kind of each observation, and what became of it: "accepted", or the reason why not."""
    check_robots: Callable[[Sequence[str], str], None]
    """Refuses robots that a session on a scenario cannot claim."""
    history_bytes: int
    """Of requests, reports and beliefs that one page of a history is made of, at most; one version always is."""

    def create(self, request: SessionRequest, write: Write) -> Answered:
        """Open a session on a scenario, at version 0, and claim robots for it.

        Raises:
            Failure: there is no such scenario, the prior is none, or a robot cannot be claimed.
        """
        robots = request.robots or []
        if robots and write.key is not None and (before := self.store.get_answer(write.key)) is not None:
            return before  # whatever the mapping says by now
        scenario = scenario_in_body(self.models, request.scenario)
        try:
            prior = scenario.prior if request.prior is None else prior_of(request.prior, scenario.poses)
        except VoaError as error:
            raise of_core(error) from error
        self.check_robots(robots, request.scenario)
        now = self.now()
        state = _summarised(SessionState(self.new_id(), request.scenario, 0, prior, prior, None, now, now), scenario)
        answer = self._session(state, scenario)
        given = Answered(answer.model_dump_json(), 0)
        answered = self.store.create_session(state, write, given, robots)
        if answered is given:  # and not what its key was answered before
            self.committed(state.id, state)
        return answered

    def get(self, id_: str) -> Session:
        """One session as it stands."""
        return self.message(self.state(id_))

    def answered(self, id_: str) -> Answered:
        """The same as JSON, with its version; what was told before is told again while it has not moved."""
        mark = self.store.session_mark(id_)
        if mark is None:
            raise not_found("session", id_)
        told = self.told.get((id_, mark), lambda: self._told(id_))
        return Answered(told.body, told.version)

    def _told(self, id_: str) -> "_Told":
        state = self.state(id_)
        return _Told(self.message(state).model_dump_json(), state.version)

    def list(self, limit: int, after: str | None) -> SessionPage:
        """All sessions without their beliefs, oldest first."""
        return SessionPage(**page(self.store.list_sessions, self._summary, limit, after))

    def delete(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> None:
        """Remove a session and its history."""
        if not self.store.delete_session(id_, key, if_match):
            raise not_found("session", id_)
        self.committed(id_, None)

    def apply_scan(self, id_: str, request: ScanRequest, write: Write) -> Answered:
        """Update the belief by a raw scan.

        What the scan says of every pose does not depend on the belief: it is worked out first, and the
        transaction only applies it, so that writers on one session hardly wait for each other.
        """
        state = self.store.get_session(id_)
        if state is None:
            return self._answered_before(id_, write)
        scenario = self.scenario_of(state)
        evidence, of_scan = evidence_of(scenario, request)
        warnings = [*self._warnings(state.scenario), *of_scan]

        def step(state: SessionState) -> Step:
            done = update(state.belief, evidence, scenario.policy)
            self.observed("scan", done.reason or "accepted")
            report = report_of(scenario, done, evidence)
            return self._observed(state, scenario, done, report, evidence.fit_rmsd_mm, warnings)

        return self._change(id_, write, step)

    def report_outcome(self, id_: str, request: OutcomeRequest, write: Write) -> Answered:
        """Update the belief by what came of a grasp attempt."""
        state = self.store.get_session(id_)
        if state is None:
            return self._answered_before(id_, write)
        scenario = self.scenario_of(state)
        if request.grasp not in scenario.table.names:
            raise of_core(UnknownName("grasp", request.grasp, scenario.table.names))
        scores = scenario.table.scores[scenario.table.names.index(request.grasp)]
        log_weights = log_outcome_weights(scores, request.success, scenario.policy.score_floor)
        warnings = self._warnings(state.scenario)

        def step(state: SessionState) -> Step:
            done = update_by_outcome(state.belief, log_weights)
            self.observed("outcome", done.reason or "accepted")
            report = report_of(scenario, done)
            return self._observed(state, scenario, done, report, state.last_fit_rmsd_mm, warnings)

        return self._change(id_, write, step)

    def put_belief(self, id_: str, request: BeliefRequest, write: Write) -> Answered:
        """Replace the belief; null: back to the session's prior."""
        state = self.store.get_session(id_)
        if state is None:
            return self._answered_before(id_, write)
        scenario = self.scenario_of(state)
        try:
            given = None if request.belief is None else Belief.of(request.belief, "belief", len(scenario.poses))
        except VoaError as error:
            raise of_core(error) from error
        warnings = self._warnings(state.scenario)

        def step(state: SessionState) -> Step:
            belief = state.prior if given is None else given
            after = replace(state, version=state.version + 1, belief=belief, updated_at=self.now())
            after = _summarised(after, scenario)
            answer = Session(**session_fields(after, scenario), warnings=list(warnings))
            return Step(after, Answered(answer.model_dump_json(), after.version), None)

        return self._change(id_, write, step)

    def history(self, id_: str, limit: int, after: str | None) -> HistoryPage:
        """Every version and what made it, the prior first."""
        self.state(id_)
        seen = -1 if after is None else position(after)
        entries = self.store.history(id_, seen, limit, self.history_bytes)
        newest = self.state(id_).version
        last = entries[-1].state.version if entries else newest
        return HistoryPage(
            items=[_history_message(entry) for entry in entries], next=str(last) if last < newest else None
        )

    def robot_looks(self, id_: str, robot: str, limit: int) -> Sequence[RobotLook]:
        """Looks of a mapped robot that a session has accepted, the newest first, at most `limit`."""
        return self.store.robot_looks(id_, robot, limit)

    def entries_after(self, id_: str, version: int, most: int) -> Sequence[HistoryEntry]:
        """History of a session after a version, oldest first, at most so many entries; none where it is gone."""
        return self.store.history(id_, version, most)

    def states_since(self, id_: str, seen: int | None, most: int) -> Sequence[SessionState] | None:
        """Read a session at every version after `seen`, at most so many; None for `seen`: as it stands. None: gone."""
        state = self.store.get_session(id_)
        if state is None:
            return None
        if seen is None or seen > state.version:
            return [state]
        if seen == state.version:
            return []
        return [entry.state for entry in self.store.history(id_, seen, most, self.history_bytes)]

    def message(self, state: SessionState) -> Session:
        """A session's state as it is told."""
        return self._session(state, self.scenario_of(state))

    def _session(self, state: SessionState, scenario: Scenario) -> Session:
        return Session(**session_fields(state, scenario), warnings=list(self._warnings(state.scenario)))

    def _warnings(self, scenario: str) -> Sequence[ProbableMistake]:
        """Probable mistakes in a scenario, which its sessions carry too."""
        return warning_messages(self.models.mistakes(scenario))

    def has_answered(self, key: IdempotencyKey) -> bool:
        """Whether a call with that key was answered, by whichever process."""
        return self.store.get_answer(key) is not None

    def _answered_before(self, id_: str, write: Write) -> Answered:
        """What a write to a session that is gone was answered while it was there; its key is remembered."""

        def step(_: SessionState) -> Step:
            raise not_found("session", id_)

        answered = self.store.change_session(id_, write, step)
        if answered is None:
            raise not_found("session", id_)
        return answered

    def _change(self, id_: str, write: Write, step: Callable[[SessionState], Step]) -> Answered:
        made: list[SessionState] = []

        def noted(state: SessionState) -> Step:
            done = step(state)
            if done.after is not None:
                made.append(done.after)
            return done

        answered = self.store.change_session(id_, write, noted)
        if answered is None:
            raise not_found("session", id_)
        for after in made:
            self.committed(id_, after)
        return answered

    def _observed(
        self,
        state: SessionState,
        scenario: Scenario,
        done: Update,
        report: UpdateReport,
        fit_rmsd_mm: float | None,
        warnings: Sequence[ProbableMistake],
    ) -> Step:
        """The effect of an observation: a new version, or an answer that says why not."""
        after = None
        if done.accepted:
            after = replace(
                state,
                version=state.version + 1,
                belief=done.belief,
                last_fit_rmsd_mm=fit_rmsd_mm,
                updated_at=self.now(),
            )
            after = _summarised(after, scenario)
        now = after or state
        answer = UpdatedSession(**session_fields(now, scenario), warnings=list(warnings), update=report)
        return Step(after, Answered(answer.model_dump_json(), now.version), report.model_dump_json())

    def update_once(self, request: UpdateRequest) -> UpdatedEstimate:
        """Update the belief in the request, or the scenario's prior where that is null, by a raw scan; stores nothing.

        Raises:
            Failure: the request does not fit the scenario, or there is no such scenario.
        """
        scenario = scenario_in_body(self.models, request.scenario)
        evidence, of_scan = evidence_of(scenario, request)
        belief = belief_in_body(scenario, request.belief)
        done = update(belief, evidence, scenario.policy)
        return UpdatedEstimate(
            **estimate_fields(scenario, done.belief),
            scenario=request.scenario,
            version=None,
            last_fit_rmsd_mm=evidence.fit_rmsd_mm if done.accepted else None,
            warnings=[*self._warnings(request.scenario), *of_scan],
            update=report_of(scenario, done, evidence),
        )

    def state(self, id_: str) -> SessionState:
        """A session named in a path."""
        state = self.store.get_session(id_)
        if state is None:
            raise not_found("session", id_)
        return state

    def scenario_of(self, state: SessionState) -> Scenario:
        """The mathematics of a session's scenario, which is never removed."""
        return scenario_in_body(self.models, state.scenario)

    def _summary(self, listed: ListedSession) -> SessionSummary:
        facts = None if listed.summary is None else json.loads(listed.summary)
        if facts is None:  # not changed since before summaries were kept
            state = self.state(listed.id)
            facts = _facts(state, self.scenario_of(state))
        return SessionSummary(
            id=listed.id,
            scenario=listed.scenario,
            version=listed.version,
            last_fit_rmsd_mm=listed.last_fit_rmsd_mm,
            created_at=listed.created_at,
            updated_at=listed.updated_at,
            **facts,
        )


def _summarised(state: SessionState, scenario: Scenario) -> SessionState:
    """A session with what a list shows of its belief."""
    return replace(state, summary=json.dumps(_facts(state, scenario)))


def _facts(state: SessionState, scenario: Scenario) -> dict[str, Any]:
    choice = best_grasp(scenario.table, state.belief.p)
    return {
        "best_grasp": None if choice.index is None else scenario.table.names[choice.index],
        "expected_score": choice.expected_score,
        "entropy_nats": state.belief.entropy_nats,
    }


def scenario_in_body(models: Models, id_: str) -> Scenario:
    """The mathematics of a scenario that a body names."""
    model = models.get(id_)
    if model is None:
        raise UnknownReference(f"there is no scenario {id_!r}: create it with POST /v1/scenarios")
    return model.scenario


def belief_in_body(scenario: Scenario, given: Sequence[float] | None) -> Belief:
    """Read the belief that a body gives; None: the scenario's prior.

    Raises:
        Failure: it is no belief over the scenario's poses.
    """
    if given is None:
        return scenario.prior
    try:
        return Belief.of(given, "belief", len(scenario.poses))
    except VoaError as error:
        raise of_core(error) from error


def evidence_of(scenario: Scenario, request: ScanRequest) -> tuple[Evidence, list[ProbableMistake]]:
    """Compare a raw scan with every pose, and find what is probably wrong with it."""
    try:
        sensor, uncertainty = place_of(scenario, request)
        scan = scan_of(request.scan, scenario.lidar)
        evidence = scenario.evidence(scan, sensor, uncertainty)
        return evidence, warning_messages(mistakes_of_scan(scenario, scan, sensor, uncertainty, evidence))
    except VoaError as error:
        raise of_core(error) from error


def _history_message(entry: HistoryEntry) -> HistoryEntryMessage:
    return HistoryEntryMessage(
        version=entry.state.version,
        kind=entry.kind,
        at=entry.state.updated_at,
        request=json.loads(entry.request),
        update=None if entry.report is None else UpdateReport.model_validate_json(entry.report),
    )
