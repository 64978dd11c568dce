"""Databases that are of another version, silent, full or locked: failures that say what to do."""

from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import text

from tests.support.postgres import Server
from tests.voa_store.samples import (
    THREADS,
    at_once,
    change,
    create,
    engine_of,
    key,
    next_version,
    scenario,
    stored_mesh,
    upload,
    write,
)
from voa_service.ports import Store
from voa_store.engines import connect
from voa_store.errors import Unavailable
from voa_store.records import StoredResponse
from voa_store.sql import SqlStore


@pytest.mark.parametrize("revision", ["0005", "b9999"])
def test_ping_says_when_the_tables_are_of_another_version(store: Store, database_url: str, revision: str) -> None:
    store.ping()
    engine = engine_of(database_url)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :revision"), {"revision": revision})
    engine.dispose()
    with pytest.raises(RuntimeError, match="another version"):
        store.ping()


def test_stores_that_open_an_empty_database_at_the_same_time_share_it(database_url: str) -> None:
    stores = at_once([lambda: SqlStore(database_url) for _ in range(THREADS)])
    try:
        stores[0].put_scenario(scenario("A"))
        for n, store in enumerate(stores):
            store.ping()
            create(store, f"S{n}")
        assert len(stores[-1].list_sessions(99, None).items) == THREADS
    finally:
        for store in stores:
            store.close()


def test_a_database_that_does_not_answer_is_a_failure_that_says_when_to_try_again(postgres: Server) -> None:
    store = SqlStore(postgres.new_database())
    store.put_scenario(scenario("A"))
    create(store)
    postgres.stop()
    try:
        calls: list[Callable[[], object]] = [
            lambda: store.get_session("S"),
            lambda: store.session_mark("S"),
            store.newest_session,
            lambda: store.robot_looks("A", "r", 1),
            lambda: store.robot_session("r", "A"),
            lambda: store.settle_robot("r", "A"),
            lambda: store.claim_robot("r", "S"),
            lambda: store.find_upload(upload()),
            lambda: store.history("S", -1, 9),
            lambda: store.list_sessions(9, None),
            lambda: store.put_object(stored_mesh()),
            lambda: create(store, "T", key()),
            lambda: change(store, "S", write(key()), next_version),
            lambda: store.delete_session("S", None, None),
            store.ping,
        ]
        for call in calls:
            with pytest.raises(Unavailable):
                call()
    finally:
        postgres.start()
    assert change(store, "S", write(key()), next_version) == StoredResponse("v1", 1)
    store.close()


def test_a_full_database_file_is_a_failure_and_room_again_is_enough(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    store = SqlStore(url)
    store.put_scenario(scenario("A"))
    create(store)
    engine = store._writer
    with engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA max_page_count = 1")  # SQLite takes the present size where that is more

    def fill() -> None:
        while True:
            change(store, "S", write(request='"' + "x" * 1000 + '"'), next_version)

    with pytest.raises(Unavailable):
        fill()
    newest = store.get_session("S")
    assert newest is not None
    assert len(store.history("S", -1, 9999)) == newest.version + 1
    with engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA max_page_count = 1000000")
    assert change(store, "S", write(), next_version) == StoredResponse(f"v{newest.version + 1}", newest.version + 1)
    store.close()


def test_a_row_that_is_held_is_not_waited_for_without_end_and_own_options_hold(postgres: Server) -> None:
    own = postgres.new_database() + "?options=-c%20application_name%3Dlab&connect_timeout=7"
    engines = connect(own)
    with engines.writer.connect() as connection:
        shown = [
            connection.execute(text(f"SHOW {name}")).scalar_one()
            for name in ("lock_timeout", "idle_in_transaction_session_timeout", "application_name")
        ]
    engines.dispose()
    assert shown == ["3200ms", "10s", "lab"]
