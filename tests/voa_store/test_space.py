"""Space of removed rows goes back to the file system."""

import time
from pathlib import Path

from tests.support.waiting import wait_for
from tests.voa_store.samples import change, create, engine_of, key, next_version, refuse, scenario, write
from tests.voa_store.test_removal import rows
from voa_store.backups import back_up
from voa_store.engines import connect, statement, transaction
from voa_store.records import StoredResponse
from voa_store.space import give_back
from voa_store.sql import SqlStore

LARGE = "x" * 40_000


def grown(file: Path) -> SqlStore:
    """A store with some 16 MB of history in one session."""
    store = SqlStore(f"sqlite:///{file}")
    store.put_scenario(scenario("A"))
    create(store, "S")
    for _ in range(400):
        change(store, "S", write(request=LARGE), next_version)
    return store


def test_the_file_shrinks_after_a_deletion_but_for_a_reserve(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    store = grown(file)
    before = file.stat().st_size
    store.delete_session("S", None, None)
    wait_for(lambda: file.stat().st_size < before / 2, "the space to be given back")
    store.close()
    assert 4_000_000 < file.stat().st_size < 6_000_000


def test_a_file_from_before_is_not_touched_and_its_backup_gives_space_back(tmp_path: Path) -> None:
    file = tmp_path / "old.db"
    engine = engine_of(f"sqlite:///{file}")
    with engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA auto_vacuum=NONE")
        connection.exec_driver_sql("CREATE TABLE unrelated (x)")
    engine.dispose()
    store = grown(file)
    engines = connect(f"sqlite:///{file}")
    store.delete_session("S", None, None)
    wait_for(lambda: rows(f"sqlite:///{file}") == (0, 0, 0), "the rows to go")
    assert give_back(engines.writer) == 0
    engines.dispose()
    store.close()
    assert back_up(f"sqlite:///{file}", tmp_path / "backup.db").size < file.stat().st_size / 2


def test_readers_connect_while_another_connection_writes(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    SqlStore(url).close()
    writing, reading = connect(url), connect(url)
    with transaction(writing.writer) as connection:
        connection.exec_driver_sql("PRAGMA user_version=1")
        began = time.monotonic()
        with statement(reading.single) as other:  # a new connection: it once waited here, for 5 s, and failed then
            assert other.exec_driver_sql("PRAGMA user_version").scalar_one() == 0
        assert time.monotonic() - began < 3.0
    writing.dispose()
    reading.dispose()


def test_a_response_without_a_session_is_kept(tmp_path: Path) -> None:
    store = SqlStore(f"sqlite:///{tmp_path / 'voa.db'}")
    store.put_scenario(scenario("A"))
    create(store, "S", key(scope="caller"))
    change(store, "S", write(key("K")), refuse)
    store.forget_responses(60.0, lambda _: None)
    assert store.get_response(key("K")) == StoredResponse("refused at v0", 0)
    store.close()
