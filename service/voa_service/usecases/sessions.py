"""Sessions: open, read, list and delete them, and read their histories."""

import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

from voa_msgs.sessions import HistoryPage, Session, SessionPage, SessionRequest, SessionSummary
from voa_service.failures import UnknownReference, not_found
from voa_service.mapping.beliefs import prior_of
from voa_service.mapping.estimates import absent_of, belief_summary, session_message, summary_of
from voa_service.mapping.histories import history_message
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.models import Model, Models
from voa_service.mapping.under_way import announced_looks
from voa_service.ports import Clock, IdSource, Store
from voa_service.runtime.cache import Cache
from voa_service.usecases.pages import page, position
from voa_store.records import (
    HistoryEntry,
    IdempotencyKey,
    ListedSession,
    RobotLook,
    SessionState,
    StoredResponse,
    Write,
)


@dataclass(frozen=True)
class _CachedResponse(StoredResponse):
    """The response to a read of a session, as an entry of the cache."""

    @property
    def nbytes(self) -> int:
        return len(self.body)


@dataclass(frozen=True)
class Sessions:
    """Use cases about sessions as a whole; `usecases.updates` changes their beliefs.

    Attributes:
        store: where sessions are kept.
        models: of the sessions' scenarios.
        now: clock.
        new_id: source of ids.
        responses: cache of the responses to reads, by session and by its last change.
        committed: called after each commit with the session's id and new state; None: it was deleted.
        check_robots: raises a failure for robots that a new session on a scenario cannot claim.
        history_bytes: a page of a history ends once requests, reports and beliefs add up to so many bytes.
    """

    store: Store
    models: Models
    now: Clock
    new_id: IdSource
    responses: Cache
    committed: Callable[[str, SessionState | None], None]
    check_robots: Callable[[Sequence[str], str], None]
    history_bytes: int

    def create(self, request: SessionRequest, write: Write) -> StoredResponse:
        """Open a session on a scenario, at version 0, and claim robots for it.

        Raises:
            Failure: there is no such scenario, or a robot cannot be claimed.
            VoaError: the prior is not a belief over the scenario's poses.
        """
        robots = request.robots or []
        if robots and write.key is not None and (before := self.store.get_response(write.key)) is not None:
            return before  # a repetition succeeds, even if the mapping of robots has changed since
        scenario = model_in_body(self.models, request.scenario).scenario
        prior = scenario.prior if request.prior is None else prior_of(request.prior, scenario.poses)
        self.check_robots(robots, request.scenario)
        now = self.now()
        record = LookRecord(log_odds_absent=scenario.start.log_odds_absent)
        summary, looks = summary_of(scenario, prior, record), record.text()
        state = SessionState(self.new_id(), request.scenario, 0, prior, prior, None, now, now, summary, looks)
        own = StoredResponse(self.message(state).model_dump_json(), 0)
        response = self.store.create_session(state, write, own, robots)
        if response is own:  # otherwise the key was used before, and the session exists already
            self.committed(state.id, state)
        return response

    def response(self, id_: str) -> StoredResponse:
        """Read a session as JSON with its version; the response is kept until the session changes.

        Raises:
            NotFound: there is no such session.
        """
        mark = self.store.session_mark(id_)
        if mark is None:
            raise not_found("session", id_)
        under_way = tuple(look.id for look in announced_looks(mark.under_way, self.now()))
        key = id_, mark.version, mark.updated_at, under_way
        cached = self.responses.get(key, lambda: self._cached_response(id_))
        return StoredResponse(cached.body, cached.version)

    def list(self, limit: int, after: str | None, only: Collection[str] | None = None) -> SessionPage:
        """List sessions without their beliefs, oldest first, in pages.

        Args:
            limit: most sessions of the page.
            after: `next` of the page before; None: from the start.
            only: ids of the only sessions to list; None: all.

        Raises:
            InvalidRequest: `after` is not a cursor.
        """
        listing = partial(self.store.list_sessions, only=only)
        return SessionPage(**page(listing, self._summary, limit, after))

    def delete(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> None:
        """Delete a session with its history.

        Raises:
            NotFound: there is no such session.
            StoreError: it has another version, or the key was used for another request.
        """
        if not self.store.delete_session(id_, key, if_match):
            raise not_found("session", id_)
        self.committed(id_, None)

    def delete_version(self, id_: str, version: int) -> bool:
        """Delete a session that has a version, with its history; False: there is no such session.

        Raises:
            VersionMismatch: it has another version.
        """
        deleted = self.store.delete_session(id_, None, frozenset({version}))
        if deleted:
            self.committed(id_, None)
        return deleted

    def history(self, id_: str, limit: int, after: str | None, *, beliefs: bool = False) -> HistoryPage:
        """List the versions of a session with the requests that made them, the prior first, in pages.

        Args:
            id_: of the session.
            limit: most versions of the page.
            after: `next` of the page before; None: from the start.
            beliefs: True: each version has its belief and best grasp, too.

        Raises:
            NotFound: there is no such session.
            InvalidRequest: `after` is not a cursor.
        """
        scenario = self.model_of(self.state(id_)).scenario if beliefs else None
        seen = -1 if after is None else position(after)
        entries = self.store.history(id_, seen, limit, self.history_bytes)
        newest = self.state(id_).version
        last = entries[-1].state.version if entries else newest
        return HistoryPage(
            items=[history_message(entry, scenario) for entry in entries], next=str(last) if last < newest else None
        )

    def robot_looks(self, id_: str, robot: str, limit: int) -> Sequence[RobotLook]:
        """Read at most `limit` looks of a mapped robot that a session has accepted, the newest first."""
        return self.store.robot_looks(id_, robot, limit)

    def entries_after(self, id_: str, version: int, most: int) -> Sequence[HistoryEntry]:
        """Read at most `most` entries of a history after a version, oldest first; empty: no such session."""
        return self.store.history(id_, version, most)

    def states_since(self, id_: str, seen: int | None, most: int) -> Sequence[SessionState] | None:
        """Read at most `most` states of a session after version `seen`, oldest first; None: there is no such session.

        Without `seen`, or where the session is older than that, the newest state alone. Announced looks belong to no
        version: every state has those that are under way now.
        """
        state = self.store.get_session(id_)
        if state is None:
            return None
        if seen is None or seen > state.version:
            return [state]
        if seen == state.version:
            return []
        entries = self.store.history(id_, seen, most, self.history_bytes)
        return [replace(entry.state, under_way=state.under_way) for entry in entries]

    def has_response(self, key: IdempotencyKey) -> bool:
        """Return True if any process has already answered a call with this key."""
        return self.store.get_response(key) is not None

    def message(self, state: SessionState) -> Session:
        """Convert a session's state to a message, with the warnings about its scenario."""
        return session_message(self.model_of(state).scenario, state, self.models.warnings(state.scenario), self.now())

    def state(self, id_: str) -> SessionState:
        """Read a session that a path names.

        Raises:
            NotFound: there is no such session.
        """
        state = self.store.get_session(id_)
        if state is None:
            raise not_found("session", id_)
        return state

    def model_of(self, state: SessionState) -> Model:
        """Return the model of a session's scenario; a scenario with sessions is never removed."""
        return model_in_body(self.models, state.scenario)

    def _cached_response(self, id_: str) -> _CachedResponse:
        state = self.state(id_)
        return _CachedResponse(self.message(state).model_dump_json(), state.version)

    def _summary(self, listed: ListedSession) -> SessionSummary:
        if listed.summary is None:  # the session has not changed since summaries were introduced
            state = self.state(listed.id)
            facts = belief_summary(self.model_of(state).scenario, state.belief, absent_of(record_of(state.looks)))
        else:
            facts = json.loads(listed.summary)
        return SessionSummary(
            id=listed.id,
            scenario=listed.scenario,
            version=listed.version,
            last_fit_rmsd_mm=listed.last_fit_rmsd_mm,
            created_at=listed.created_at,
            updated_at=listed.updated_at,
            **facts,
        )


def model_in_body(models: Models, id_: str) -> Model:
    """Return the model of a scenario that a request's body names.

    Raises:
        UnknownReference: there is no such scenario.
    """
    model = models.get(id_)
    if model is None:
        raise UnknownReference(f"there is no scenario {id_!r}: create it with POST /v1/scenarios")
    return model
