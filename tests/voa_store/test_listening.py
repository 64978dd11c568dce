"""On PostgreSQL a process is notified at once, by LISTEN, of sessions that another process changes."""

from collections.abc import Iterator
from queue import Queue

import pytest
from sqlalchemy import create_engine, text

from tests.support.postgres import Server
from tests.voa_store.samples import change, create, next_version, refuse, scenario, write
from voa_store.sql import SqlStore

SECONDS = 30.0


@pytest.fixture
def url(postgres: Server) -> str:
    return postgres.new_database()


@pytest.fixture
def writer(url: str) -> Iterator[SqlStore]:
    store = SqlStore(url)
    store.put_scenario(scenario("A"))
    yield store
    store.close()


@pytest.fixture
def changed_sessions(url: str, writer: SqlStore) -> Iterator["Queue[str]"]:
    """Ids of the sessions of which another process's store is notified; it listens already."""
    changed: Queue[str] = Queue()
    store = SqlStore(url)
    store.listen(changed.put)
    create(writer, "first")
    while changed.empty():  # until it listens: earlier notifications are lost
        change(writer, "first", write(), next_version)
        if not changed.empty() or _wait(changed):
            break
    yield changed
    store.close()


def _wait(changed: "Queue[str]") -> bool:
    with changed.not_empty:
        return changed.not_empty.wait(0.2)


def _next(changed: "Queue[str]", besides: str = "first") -> str:
    while (session := changed.get(timeout=SECONDS)) == besides:
        pass
    return session


def test_a_new_version_notifies_the_other_process(writer: SqlStore, changed_sessions: "Queue[str]") -> None:
    create(writer)
    change(writer, "S", write(), next_version)
    assert _next(changed_sessions) == "S"


def test_a_deleted_session_notifies_the_other_process(writer: SqlStore, changed_sessions: "Queue[str]") -> None:
    create(writer)
    assert writer.delete_session("S", None, None)
    assert _next(changed_sessions) == "S"


def test_what_changes_nothing_is_not_said(writer: SqlStore, changed_sessions: "Queue[str]") -> None:
    create(writer, "S")
    create(writer, "T")
    change(writer, "S", write(), refuse)
    change(writer, "T", write(), next_version)
    assert _next(changed_sessions) == "T"


def test_it_listens_again_after_its_connection_was_cut(
    url: str, writer: SqlStore, changed_sessions: "Queue[str]"
) -> None:
    create(writer)
    engine = create_engine(url)
    with engine.begin() as connection:
        cut = text(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE query LIKE 'LISTEN %' AND datname = :db"
        )
        assert connection.execute(cut, {"db": engine.url.database}).all() == [(True,)]
    engine.dispose()
    while not _wait(changed_sessions):
        change(writer, "S", write(), next_version)
    assert _next(changed_sessions) == "S"


def test_sqlite_says_nothing_and_is_looked_at(tmp_path: object) -> None:
    store = SqlStore(f"sqlite:///{tmp_path}/voa.db")
    changed: list[str] = []
    store.listen(changed.append)
    store.put_scenario(scenario("A"))
    create(store)
    change(store, "S", write(), next_version)
    store.close()
    assert changed == []
