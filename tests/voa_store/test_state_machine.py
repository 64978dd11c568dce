"""The store against a dictionary: hypothesis looks for a sequence of calls after which they differ."""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from sqlalchemy import create_engine

from tests.support.scale import scaled
from tests.voa_store.samples import Result, change
from voa_core.filtering import Belief
from voa_service.ports import Store
from voa_store.errors import StoreError
from voa_store.records import IdempotencyKey, RobotLook, SessionState, StoredResponse, StoredScenario, Write
from voa_store.sql import SqlStore
from voa_store.tables import metadata

SETTINGS = settings(
    max_examples=scaled(15, 300),
    stateful_step_count=scaled(25, 60),
    deadline=None,
    suppress_health_check=list(HealthCheck),
    print_blob=True,
)
START = datetime(2026, 1, 1, tzinfo=UTC)

IDS = st.sampled_from(["S", "T", "U"])
ROBOTS = st.sampled_from(["q", "r"])
LOOKS = st.none() | st.builds(RobotLook, ROBOTS, st.integers(1, 3), st.sampled_from(["d", "e"]))
CREWS = st.sampled_from([(), (), ("q",), ("r", "q")])
KEYS = st.sampled_from([None, "a", "b", "c"])
FINGERPRINTS = st.sampled_from(["F", "F", "F", "G"])
SEEN = st.none() | st.frozensets(st.integers(0, 6), max_size=3)
REQUESTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)
FLOATS = st.floats(allow_nan=False, width=64)
BELIEFS = st.lists(st.tuples(FLOATS, FLOATS), min_size=1, max_size=4)
FITS = st.none() | st.floats(allow_nan=False, allow_infinity=False)
TEXTS = st.none() | REQUESTS


@dataclass
class Entry:
    """A version of a session, as bytes."""

    version: int
    belief: bytes
    fit: str
    request: str
    report: str | None
    record: str | None = None
    """Record of looks."""


@dataclass
class Model:
    """Model of the store: the content that it must hold."""

    sessions: dict[str, list[Entry]] = field(default_factory=dict)
    keys: dict[tuple[str, str], tuple[str, StoredResponse]] = field(default_factory=dict)
    order: list[str] = field(default_factory=list)
    opened: dict[str, int] = field(default_factory=dict)
    """Order of opening of each existing session."""
    count: int = 0
    """Sessions opened so far."""
    claims: dict[str, tuple[str | None, int]] = field(default_factory=dict)
    """Session of each robot, and the order of its opening."""
    looks: dict[str, list[RobotLook]] = field(default_factory=dict)
    """Accepted looks of each session."""
    under_way: dict[str, str | None] = field(default_factory=dict)
    """Announced looks of each session, which belong to no version."""

    def has(self, session: str, look: RobotLook | None) -> bool:
        """True if a session has a look of the same robot with the same number."""
        named = [(each.robot, each.number) for each in self.looks.get(session, [])]
        return look is not None and (look.robot, look.number) in named

    def looks_of(self, session: str, robot: str) -> list[RobotLook]:
        """Looks of a robot that a session has, the newest first."""
        own = [each for each in self.looks.get(session, []) if each.robot == robot]
        return sorted(own, key=lambda each: -each.number)

    def of_robot(self, robot: str) -> str | None:
        """The session that a look of a robot is for."""
        claimed, after = self.claims.get(robot, ("never claimed", -1))
        if claimed is None or claimed in self.opened:
            return claimed
        opened_after = [id_ for id_ in self.order if self.opened[id_] > after]
        return opened_after[-1] if opened_after else None

    def claim(self, robot: str, session: str | None) -> None:
        """Make a session, or none, the robot's own."""
        self.claims[robot] = session, -1 if session is None else self.opened[session]


def bits(belief: Belief) -> bytes:
    return belief.p.tobytes() + b"|" + belief.log_p.tobytes()


def of(pairs: list[tuple[float, float]]) -> Belief:
    """Any float64 at all: the store must not care."""
    array = np.array(pairs, dtype=np.float64)
    return Belief(array[:, 0].copy(), array[:, 1].copy())


def exactly(fit: float | None) -> str:
    return "none" if fit is None else float(fit).hex()


class Histories(RuleBasedStateMachine):
    """Sessions are opened, moved, refused and deleted, with and without keys, through either of two stores."""

    stores: tuple[Store, Store]
    empty: Callable[[], None]

    @initialize()
    def begin(self) -> None:
        self.empty()
        self.model = Model()
        self.stores[0].put_scenario(StoredScenario("A", "A", "{}", START))

    def _named(self, scope: str, key: str | None, fingerprint: str) -> IdempotencyKey | None:
        return None if key is None else IdempotencyKey(scope, key, fingerprint)

    def _expected(self, named: IdempotencyKey | None) -> StoredResponse | str | None:
        """By its key: an answer of before, that it was reused, or nothing."""
        if named is None or (named.scope, named.key) not in self.model.keys:
            return None
        fingerprint, answered = self.model.keys[named.scope, named.key]
        return answered if fingerprint == named.fingerprint else "KeyReused"

    def _remember(self, named: IdempotencyKey | None, answered: StoredResponse) -> None:
        if named is not None:
            self.model.keys[named.scope, named.key] = named.fingerprint, answered

    @rule(
        store=st.integers(0, 1),
        id_=IDS,
        key=KEYS,
        fingerprint=FINGERPRINTS,
        belief=BELIEFS,
        request=REQUESTS,
        robots=CREWS,
    )
    def create(
        self,
        store: int,
        id_: str,
        key: str | None,
        fingerprint: str,
        belief: list[tuple[float, float]],
        request: str,
        robots: tuple[str, ...],
    ) -> None:
        named = self._named("caller", key, fingerprint)
        expected = self._expected(named)
        if expected is None and id_ in self.model.sessions:
            return  # ids are new: the service makes them
        prior = of(belief)
        state = SessionState(id_, "A", 0, prior, prior, None, START, START)
        answer = StoredResponse(f"created {id_} {request}", 0)
        result = outcome(
            lambda: self.stores[store].create_session(state, Write("prior", request, named, None), answer, robots)
        )
        assert result == (answer if expected is None else expected)
        if expected is None:
            self._remember(named, answer)
            self.model.sessions[id_] = [Entry(0, bits(prior), "none", request, None)]
            self.model.order.append(id_)
            self.model.count += 1
            self.model.opened[id_] = self.model.count
            for robot in robots:
                self.model.claim(robot, id_)

    @rule(
        store=st.integers(0, 1),
        id_=IDS,
        key=KEYS,
        fingerprint=FINGERPRINTS,
        seen=SEEN,
        belief=BELIEFS,
        fit=FITS,
        request=REQUESTS,
        accepted=st.sampled_from([True, True, True, False]),
        look=LOOKS,
        record=TEXTS,
    )
    def change(
        self,
        store: int,
        id_: str,
        key: str | None,
        fingerprint: str,
        seen: frozenset[int] | None,
        belief: list[tuple[float, float]],
        fit: float | None,
        request: str,
        accepted: bool,
        look: RobotLook | None,
        record: str | None,
    ) -> None:
        named = self._named(f"session:{id_}", key, fingerprint)
        log = self.model.sessions.get(id_)
        after_belief = of(belief)
        ran: list[SessionState] = []

        def step(state: SessionState) -> Result:
            ran.append(state)
            version = state.version + accepted
            after = replace(
                state,
                version=version,
                belief=after_belief,
                last_fit_rmsd_mm=fit,
                updated_at=START + timedelta(seconds=version),
                looks=record,
            )
            return Result(
                StoredResponse(f"{request} {accepted}", version), after if accepted else None, f"report {request}"
            )

        write = Write("scan", request, named, seen, look)
        result = outcome(lambda: change(self.stores[store], id_, write, step))
        expected = self._expected(named)
        if expected is not None or log is None:
            assert (result, ran) == (expected, [])
        elif seen is not None and log[-1].version not in seen:
            assert (result, ran) == ("VersionMismatch", [])
        else:
            (state,) = ran
            assert (state.version, bits(state.belief)) == (log[-1].version, log[-1].belief)
            answer = StoredResponse(f"{request} {accepted}", log[-1].version + accepted)
            if accepted and self.model.has(id_, look):
                assert result == "LookRepeated"
                return
            assert result == answer
            self._remember(named, answer)
            if accepted:
                version = log[-1].version + 1
                entry = Entry(version, bits(after_belief), exactly(fit), request, f"report {request}", record)
                log.append(entry)
                self.model.looks.setdefault(id_, []).extend([] if look is None else [look])

    @rule(store=st.integers(0, 1), id_=IDS, key=KEYS, fingerprint=FINGERPRINTS, under_way=TEXTS)
    def announce(self, store: int, id_: str, key: str | None, fingerprint: str, under_way: str | None) -> None:
        named = self._named(f"session:{id_}", key, fingerprint)
        log = self.model.sessions.get(id_)
        ran: list[SessionState] = []

        def step(state: SessionState) -> Result:
            ran.append(state)
            answer = StoredResponse(f"announced {under_way}", state.version)
            return Result(answer, replace(state, under_way=under_way))

        result = outcome(lambda: change(self.stores[store], id_, Write("look", "look", named, None), step))
        expected = self._expected(named)
        if expected is not None or log is None:
            assert (result, ran) == (expected, [])
            return
        assert [state.under_way for state in ran] == [self.model.under_way.get(id_)]
        assert result == StoredResponse(f"announced {under_way}", log[-1].version)
        self._remember(named, result)
        self.model.under_way[id_] = under_way

    @rule(store=st.integers(0, 1), id_=IDS, key=KEYS, fingerprint=FINGERPRINTS, seen=SEEN)
    def delete(self, store: int, id_: str, key: str | None, fingerprint: str, seen: frozenset[int] | None) -> None:
        named = self._named(f"session:{id_}", key, fingerprint)
        log = self.model.sessions.get(id_)
        result = outcome(lambda: self.stores[store].delete_session(id_, named, seen))
        expected = self._expected(named)
        if expected is not None:
            assert result == (True if isinstance(expected, StoredResponse) else expected)
        elif log is None:
            assert result is False
        elif seen is not None and log[-1].version not in seen:
            assert result == "VersionMismatch"
        else:
            assert result is True
            self._remember(named, StoredResponse("", log[-1].version))
            del self.model.sessions[id_]
            self.model.order.remove(id_)
            del self.model.opened[id_]
            self.model.looks.pop(id_, None)
            self.model.under_way.pop(id_, None)

    @rule(store=st.integers(0, 1), robot=ROBOTS)
    def settle(self, store: int, robot: str) -> None:
        expected = self.model.of_robot(robot)
        assert self.stores[store].settle_robot(robot, "A") == expected
        if expected is not None and self.model.claims.get(robot, (None, -1))[0] != expected:
            self.model.claim(robot, expected)

    @rule(store=st.integers(0, 1), robot=ROBOTS, id_=st.none() | IDS)
    def claim(self, store: int, robot: str, id_: str | None) -> None:
        there = id_ is None or id_ in self.model.sessions
        assert self.stores[store].claim_robot(robot, id_) is there
        if there:
            self.model.claim(robot, id_)

    @precondition(lambda self: self.model.sessions)
    @rule(store=st.integers(0, 1), id_=IDS, after=st.integers(-1, 8), limit=st.integers(1, 5))
    def read_a_part_of_the_history(self, store: int, id_: str, after: int, limit: int) -> None:
        log = self.model.sessions.get(id_, [])
        expected = [entry.version for entry in log if entry.version > after][:limit]
        assert [entry.state.version for entry in self.stores[store].history(id_, after, limit)] == expected

    @rule(store=st.integers(0, 1), limit=st.integers(1, 4))
    def list_in_pages(self, store: int, limit: int) -> None:
        listed: list[str] = []
        after = None
        while True:
            page = self.stores[store].list_sessions(limit, after)
            listed += [state.id for state in page.items]
            after = page.next
            if after is None:
                break
        assert listed == self.model.order

    @invariant()
    def every_robot_s_session_is_as_the_model_says(self) -> None:
        if hasattr(self, "model"):
            for robot in ("q", "r"):
                assert {store.robot_session(robot, "A") for store in self.stores} == {self.model.of_robot(robot)}

    @invariant()
    def every_robot_s_looks_are_as_the_model_says(self) -> None:
        if hasattr(self, "model"):
            for id_, robot in itertools.product(("S", "T", "U"), ("q", "r")):
                assert self.stores[1].robot_looks(id_, robot, 9) == self.model.looks_of(id_, robot)

    @invariant()
    def every_session_is_as_the_model_says(self) -> None:
        if not hasattr(self, "model"):
            return
        for id_ in ("S", "T", "U"):
            log = self.model.sessions.get(id_)
            state = self.stores[0].get_session(id_)
            entries = [
                Entry(
                    each.state.version,
                    bits(each.state.belief),
                    exactly(each.state.last_fit_rmsd_mm),
                    each.request,
                    each.report,
                    each.state.looks,
                )
                for each in self.stores[1].history(id_, -1, 1000)
            ]
            if log is None:
                assert (state, entries) == (None, [])
                continue
            assert entries == log
            assert state is not None
            assert (state.version, bits(state.belief)) == (log[-1].version, log[-1].belief)
            assert exactly(state.last_fit_rmsd_mm) == log[-1].fit
            assert bits(state.prior) == log[0].belief
            assert (state.looks, state.under_way) == (log[-1].record, self.model.under_way.get(id_))


def outcome(call: Callable[[], Any]) -> Any:
    """Return the result of a call, or the name of the error's class."""
    try:
        return call()
    except StoreError as error:
        return type(error).__name__


@pytest.fixture
def machine(database_url: str) -> Iterator[type[Histories]]:
    """The machine on one database, which each run begins by emptying."""
    pair = SqlStore(database_url), SqlStore(database_url)
    engine = create_engine(database_url)

    def erase() -> None:
        with engine.begin() as connection:
            for table in reversed(metadata.sorted_tables):
                connection.execute(table.delete())

    class Here(Histories):
        stores = pair
        empty = staticmethod(erase)

    yield Here
    engine.dispose()
    for store in pair:
        store.close()


def test_the_store_behaves_like_a_dictionary(machine: type[Histories]) -> None:
    run_state_machine_as_test(machine, settings=SETTINGS)


def test_infinities_are_compared_too() -> None:
    """The comparison by bytes distinguishes 0.0 from -0.0, and every bit."""
    assert bits(of([(0.0, -math.inf)])) != bits(of([(-0.0, -math.inf)]))
    assert exactly(0.1 + 0.2) != exactly(0.3)
