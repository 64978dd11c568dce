"""A deleted session is gone at once; its rows go a few at a time, and whatever a kill left goes at the next start."""

from itertools import pairwise

import pytest
from sqlalchemy import text

from tests.support.waiting import wait_for
from tests.voa_store.samples import Open, change, create, engine_of, key, next_version, scenario, write
from voa_service.ports import Store
from voa_store.engines import connect, transaction
from voa_store.records import RobotLook, Write
from voa_store.removal import Remover, remove_some

VERSIONS = 150


def grown(store: Store, id_: str = "S", versions: int = VERSIONS) -> None:
    create(store, id_, robots=["r"])
    for number in range(1, versions + 1):
        look = RobotLook("r", number, "0" * 64)
        change(store, id_, Write("scan", "{}", None, None, look), next_version)


def rows(url: str) -> tuple[int, int, int]:
    """Rows of histories, looks and sessions."""
    engine = engine_of(url)
    with engine.connect() as connection:
        counts = [
            connection.execute(text(f"SELECT count(*) FROM {table}")).scalar_one()  # noqa: S608 - our names
            for table in ("history", "robot_looks", "sessions")
        ]
    engine.dispose()
    return counts[0], counts[1], counts[2]


def test_a_long_session_is_gone_at_once_and_its_rows_soon(store: Store, database_url: str) -> None:
    grown(store)
    create(store, "T")
    assert store.delete_session("S", key("D"), frozenset({VERSIONS}))
    assert store.get_session("S") is None
    assert store.session_mark("S") is None
    assert store.history("S", -1, 9) == []
    assert change(store, "S", write(), next_version) is None
    assert not store.delete_session("S", None, None)
    assert store.delete_session("S", key("D"), None), "its key is remembered"
    assert [item.id for item in store.list_sessions(9, None).items] == ["T"]
    assert store.robot_session("r", "A") == "T", "the newest that was opened after it"
    wait_for(lambda: rows(database_url) == (1, 0, 1), "its rows to go")


@pytest.fixture
def left(opened: Open, database_url: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A database whose service was killed after it answered a DELETE."""
    store = opened()
    store.put_scenario(scenario("A"))
    grown(store)
    create(store, "T")
    with monkeypatch.context() as patched:
        patched.setattr(Remover, "wake", lambda self: None)
        assert store.delete_session("S", None, None)
    store.close()
    assert rows(database_url) == (VERSIONS + 2, VERSIONS, 2)
    return database_url


def test_what_a_kill_left_is_removed_at_the_next_start(left: str, opened: Open) -> None:
    store = opened()
    assert store.get_session("S") is None
    wait_for(lambda: rows(left) == (1, 0, 1), "its rows to go")
    assert store.get_session("T") is not None


def test_each_transaction_removes_no_more_rows_than_its_limit(left: str) -> None:
    engines = connect(left)
    seen = [rows(left)]
    removed = True
    while removed:
        with transaction(engines.writer) as connection:
            removed = remove_some(connection, 40)
        seen.append(rows(left))
    engines.dispose()
    assert seen[-1] == (1, 0, 1)
    for before, after in pairwise(seen):
        assert sum(before) - sum(after) <= 40


def test_two_processes_remove_side_by_side(left: str, opened: Open) -> None:
    for store in (opened(), opened()):
        store.ping()
    wait_for(lambda: rows(left) == (1, 0, 1), "its rows to go")
