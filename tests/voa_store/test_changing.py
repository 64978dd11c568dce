"""Writers of different sessions that wait for each other share one transaction, and none suffers from another."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import ContextVar
from dataclasses import replace
from functools import partial

import pytest
from sqlalchemy import select, update

from tests.support.postgres import Server
from tests.support.waiting import wait_for
from tests.voa_store.samples import (
    Result,
    change,
    create,
    engine_of,
    key,
    looking,
    next_version,
    refuse,
    scenario,
    write,
)
from voa_service.ports import Store
from voa_store.errors import DamagedData, LookRepeated, SessionMissing, StoreError, VersionMismatch
from voa_store.records import RobotLook, SessionState, StoredResponse, Write
from voa_store.sql import SqlStore
from voa_store.tables import sessions

SECONDS = 60.0
REQUEST: ContextVar[str] = ContextVar("REQUEST", default="nobody's")
Step = Callable[[SessionState], Result]


def waiting(store: Store) -> int:
    """Number of writes that wait for their group."""
    assert isinstance(store, SqlStore)
    return len(store._session_writer._groups._waiting)


def wait_alike(store: Store, count: int) -> bool:
    """True while exactly so many writes wait for their group."""
    return waiting(store) == count


def together(store: Store, calls: list[tuple[str, Write, Step]]) -> list["Future[StoredResponse | None]"]:
    """Make writes while another one, of the session "first", is under way: they become one group."""
    entered, let_go = threading.Event(), threading.Event()

    def slow(state: SessionState) -> Result:
        entered.set()
        assert let_go.wait(SECONDS)
        return next_version(state)

    with ThreadPoolExecutor(len(calls) + 1) as pool:
        first = pool.submit(change, store, "first", write(), slow)
        assert entered.wait(SECONDS)
        futures = []
        for count, call in enumerate(calls, 1):
            futures.append(pool.submit(change, store, *call))
            wait_for(partial(wait_alike, store, count), "the write to wait")
        let_go.set()
        first.result(SECONDS)
        for future in futures:
            future.exception(SECONDS)
    return futures


@pytest.fixture
def sessions_of(store: Store) -> Callable[[str], Store]:
    def made(ids: str) -> Store:
        for id_ in ("first", *ids):
            create(store, id_)
        return store

    return made


def version(store: Store, id_: str) -> int:
    state = store.get_session(id_)
    assert state is not None
    return state.version


def test_writers_that_wait_are_committed_in_one_transaction(sessions_of: Callable[[str], Store]) -> None:
    store = sessions_of("STUV")
    transactions: list[float] = []
    store.measure(transactions.append)
    futures = together(store, [(id_, write(), next_version) for id_ in "STUV"])
    assert len(transactions) == 2
    assert [future.result() for future in futures] == [StoredResponse("v1", 1)] * 4
    assert [[entry.state.version for entry in store.history(id_, -1, 9)] for id_ in "STUV"] == [[0, 1]] * 4


def test_what_a_write_raises_leaves_the_others_of_its_group_alone(sessions_of: Callable[[str], Store]) -> None:
    store = sessions_of("STUVW")
    look = RobotLook("r", 1, "d")
    change(store, "W", replace(write(), look=look), next_version)

    def fails(_: SessionState) -> Result:
        raise ArithmeticError("of this write alone")

    futures = together(
        store,
        [
            ("S", write(), next_version),
            ("T", write(key("T", "session:T")), fails),
            ("U", write(None, frozenset({7})), next_version),
            ("missing", write(), next_version),
            ("W", replace(write(), look=look), next_version),
            ("V", write(key("V", "session:V")), refuse),
        ],
    )
    kinds = [type(future.exception()) for future in futures if future.exception() is not None]
    assert kinds == [ArithmeticError, VersionMismatch, LookRepeated]
    assert futures[0].result() == StoredResponse("v1", 1)
    assert futures[3].result() is None
    assert futures[5].result() == StoredResponse("refused at v0", 0)
    assert [version(store, id_) for id_ in "STUVW"] == [1, 0, 0, 0, 1]
    assert store.get_response(key("T", "session:T")) is None
    assert change(store, "V", write(key("V", "session:V")), next_version) == StoredResponse("refused at v0", 0)


def test_a_group_that_the_database_refuses_for_one_is_done_one_by_one(
    sessions_of: Callable[[str], Store], database_url: str
) -> None:
    store = sessions_of("STU")
    change(store, "T", write(), next_version)
    engine = engine_of(database_url)
    with engine.connect() as connection:
        (before,) = connection.execute(select(sessions).where(sessions.c.id == "T")).mappings().all()
    change(store, "T", write(), next_version)
    with engine.begin() as connection:  # set back by the disk
        connection.execute(update(sessions).where(sessions.c.id == "T").values(**before))
    engine.dispose()
    futures = together(store, [(id_, write(key(id_, f"session:{id_}")), next_version) for id_ in "STU"])
    assert isinstance(futures[1].exception(), DamagedData)
    assert [futures[index].result() for index in (0, 2)] == [StoredResponse("v1", 1)] * 2
    assert [len(store.history(id_, -1, 9)) for id_ in "SU"] == [2, 2]


def test_keys_and_looks_of_a_group_are_stored_for_each(sessions_of: Callable[[str], Store]) -> None:
    store = sessions_of("ST")
    writes = {
        id_: replace(write(key("K", f"session:{id_}"), request=f'"{id_}"'), look=RobotLook("r", 1, id_)) for id_ in "ST"
    }
    together(store, [(id_, writes[id_], looking(f'"{id_}"')) for id_ in "ST"])
    for id_ in "ST":
        assert change(store, id_, writes[id_], refuse) == StoredResponse("v1", 1)
        assert store.robot_looks(id_, "r", 9) == [RobotLook("r", 1, id_)]
        (_, entry) = store.history(id_, -1, 9)
        assert (entry.request, entry.state.looks) == (f'"{id_}"', f'"{id_}"')


def test_a_step_runs_in_the_context_of_its_own_writer(sessions_of: Callable[[str], Store]) -> None:
    store = sessions_of("ST")
    seen: dict[str, str] = {}

    def step(state: SessionState) -> Result:
        seen[state.id] = REQUEST.get()
        return next_version(state)

    entered, let_go = threading.Event(), threading.Event()

    def slow(state: SessionState) -> Result:
        entered.set()
        assert let_go.wait(SECONDS)
        return step(state)

    def named(id_: str, own: Step) -> None:
        REQUEST.set(f"{id_}'s")
        change(store, id_, write(), own)

    with ThreadPoolExecutor(3) as pool:
        futures = [pool.submit(named, "first", slow)]
        assert entered.wait(SECONDS)
        futures += [pool.submit(named, id_, step) for id_ in "ST"]
        wait_for(lambda: waiting(store) == 2, "both to wait")
        let_go.set()
        for future in futures:
            future.result(SECONDS)
    assert seen == {"first": "first's", "S": "S's", "T": "T's"}


def test_a_row_that_another_process_holds_keeps_nobody_else_waiting(postgres: Server) -> None:
    url = postgres.new_database()
    store = SqlStore(url)
    store.put_scenario(scenario("A"))
    for id_ in "ST":
        create(store, id_)
    engine = engine_of(url)
    with ThreadPoolExecutor(1) as pool, engine.connect() as other:
        other.execute(select(sessions).where(sessions.c.id == "S").with_for_update())
        held = pool.submit(change, store, "S", write(), next_version)
        assert change(store, "T", write(), next_version) == StoredResponse("v1", 1)
        assert not held.done()
        other.rollback()
        assert held.result(SECONDS) == StoredResponse("v1", 1)
    engine.dispose()
    store.close()


def test_a_broken_database_is_reported_to_every_writer_of_the_group(postgres: Server) -> None:
    store = SqlStore(postgres.new_database())
    store.put_scenario(scenario("A"))
    for id_ in ("first", "S", "T"):
        create(store, id_)

    def breaks(state: SessionState) -> Result:
        postgres.stop()
        return next_version(state)

    try:
        futures = together(store, [("S", write(), breaks), ("T", write(), next_version)])
        assert all(isinstance(future.exception(), StoreError) for future in futures)
        assert not any(isinstance(future.exception(), SessionMissing) for future in futures)
    finally:
        postgres.start()
    assert [version(store, id_) for id_ in "ST"] == [0, 0]
    store.close()
