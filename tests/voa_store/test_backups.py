"""Backups are complete states of a database that is being written, and are restored only if nothing is lost by it."""

import threading
from pathlib import Path

import pytest
from sqlalchemy import text

from tests.support.releases import at_revision
from tests.voa_store.samples import change, create, engine_of, next_version, scenario, write
from voa_store.backups import CannotBackUp, back_up, restore
from voa_store.sql import SqlStore


def url_of(file: Path) -> str:
    return f"sqlite:///{file}"


def opened(file: Path, *sessions: str, versions: int = 3) -> SqlStore:
    """A store with sessions of some versions; the caller closes it."""
    store = SqlStore(url_of(file))
    store.put_scenario(scenario("A"))
    for id_ in sessions:
        create(store, id_)
        for _ in range(versions):
            change(store, id_, write(), next_version)
    return store


def filled(file: Path, *sessions: str, versions: int = 3) -> Path:
    """A closed database with sessions of some versions."""
    opened(file, *sessions, versions=versions).close()
    return file


def versions_of(file: Path, session: str) -> list[int]:
    store = SqlStore(url_of(file))
    try:
        return [entry.state.version for entry in store.history(session, -1, 100_000)]
    finally:
        store.close()


def test_a_backup_of_a_database_that_is_written_is_a_state_that_it_had(tmp_path: Path) -> None:
    store = opened(tmp_path / "voa.db", "S")
    stop, before = threading.Event(), 3

    def writing() -> None:
        while not stop.is_set():
            change(store, "S", write(), next_version)

    writer = threading.Thread(target=writing)
    writer.start()
    try:
        backups = [back_up(url_of(tmp_path / "voa.db"), tmp_path / f"{number}.db") for number in range(5)]
    finally:
        stop.set()
        writer.join()
        newest = store.get_session("S")
        store.close()
    assert newest is not None
    last = [versions_of(backup.file, "S")[-1] for backup in backups]
    assert all(backup.verified.well and backup.verified.sessions == 1 for backup in backups)
    assert before <= last[0] <= last[-1] <= newest.version
    assert last == sorted(last)
    assert versions_of(backups[-1].file, "S") == list(range(last[-1] + 1))
    assert sorted(path.name for path in tmp_path.glob("*.db*")) == [*(f"{n}.db" for n in range(5)), "voa.db"]


def test_a_file_is_replaced_only_on_request_and_a_failed_backup_leaves_it(tmp_path: Path) -> None:
    database, file = filled(tmp_path / "voa.db", "S"), tmp_path / "backup.db"
    file.write_bytes(b"precious")
    with pytest.raises(CannotBackUp, match="exists: name another file, or add --replace"):
        back_up(url_of(database), file)
    database.write_bytes(b"no database at all" * 100)
    with pytest.raises(CannotBackUp, match=r"cannot be copied"):
        back_up(url_of(database), file, replace=True)
    assert file.read_bytes() == b"precious"


def test_a_restored_database_is_that_of_the_backup_and_the_other_is_kept(tmp_path: Path) -> None:
    database, file = filled(tmp_path / "voa.db", "S"), tmp_path / "backup.db"
    back_up(url_of(database), file)
    store = SqlStore(url_of(database))
    change(store, "S", write(), next_version)
    store.close()
    restored = restore(file, url_of(database))
    assert restored.kept == tmp_path / "voa.db.before-restore-1"
    assert versions_of(database, "S") == [0, 1, 2, 3]
    assert versions_of(restored.kept, "S") == [0, 1, 2, 3, 4]
    assert restore(file, url_of(database)).kept == tmp_path / "voa.db.before-restore-2"
    assert restore(file, url_of(tmp_path / "elsewhere.db")).kept is None


def test_nothing_is_restored_under_a_service_that_runs(tmp_path: Path) -> None:
    store, file = opened(tmp_path / "voa.db", "S"), tmp_path / "backup.db"
    back_up(url_of(tmp_path / "voa.db"), file)
    with pytest.raises(CannotBackUp, match=r"is in use .*: stop the service"):
        restore(file, url_of(tmp_path / "voa.db"))
    change(store, "S", write(), next_version)
    store.close()
    assert versions_of(tmp_path / "voa.db", "S") == [0, 1, 2, 3, 4]


def test_a_damaged_backup_is_not_restored_unless_it_is_wanted(tmp_path: Path) -> None:
    database, file = filled(tmp_path / "voa.db", "S", "T"), tmp_path / "backup.db"
    back_up(url_of(database), file)
    engine = engine_of(url_of(file))
    with engine.begin() as connection:
        connection.execute(text("UPDATE history SET request = 'other' WHERE session = 'T' AND version = 2"))
    engine.dispose()
    with pytest.raises(CannotBackUp, match="has 1 damaged sessions and 0 damaged pages"):
        restore(file, url_of(database))
    assert versions_of(database, "T") == [0, 1, 2, 3]
    restored = restore(file, url_of(database), even_if_damaged=True)
    assert [(damage.session, damage.version) for damage in restored.verified.damaged] == [("T", 2)]
    assert versions_of(database, "S") == [0, 1, 2, 3]


def test_a_backup_of_a_damaged_database_says_so(tmp_path: Path) -> None:
    database = filled(tmp_path / "voa.db", "S")
    engine = engine_of(url_of(database))
    with engine.begin() as connection:
        connection.execute(text("UPDATE sessions SET last_fit_rmsd_mm = 7.0"))
    engine.dispose()
    backup = back_up(url_of(database), tmp_path / "backup.db")
    assert [damage.session for damage in backup.verified.damaged] == ["S"]


def test_a_backup_of_an_earlier_version_is_migrated_as_it_is_restored(tmp_path: Path) -> None:
    at_revision(url_of(tmp_path / "old.db"), "0001").dispose()
    restored = restore(tmp_path / "old.db", url_of(tmp_path / "voa.db"))
    assert restored.verified.sessions == 0
    store = SqlStore(url_of(tmp_path / "voa.db"))
    store.ping()
    store.close()


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("postgresql://somebody@nowhere/voa", "pg_dump --format=custom"),
        ("sqlite://", "expected a database in a file"),
        ("sqlite:////nothing/voa.db", "there is no database /nothing/voa.db"),
    ],
)
def test_other_databases_are_refused(tmp_path: Path, url: str, why: str) -> None:
    with pytest.raises(CannotBackUp, match=why):
        back_up(url, tmp_path / "backup.db")


def test_there_is_no_backup_to_restore(tmp_path: Path) -> None:
    with pytest.raises(CannotBackUp, match=r"there is no file .*missing\.db"):
        restore(tmp_path / "missing.db", url_of(tmp_path / "voa.db"))


def test_a_backup_never_replaces_the_database_or_a_file_of_it(tmp_path: Path) -> None:
    database = filled(tmp_path / "voa.db", "S")
    (tmp_path / "link.db").symlink_to(database)
    for file in ("voa.db", "voa.db-wal", "voa.db.part", "link.db"):
        with pytest.raises(CannotBackUp, match="is the database itself"):
            back_up(url_of(database), tmp_path / file, replace=True)
    with pytest.raises(CannotBackUp, match="is the database itself"):
        restore(tmp_path / "link.db", url_of(database))
    assert versions_of(database, "S") == [0, 1, 2, 3]


def test_a_database_that_is_too_damaged_to_open_is_kept_and_replaced(tmp_path: Path) -> None:
    database, file = filled(tmp_path / "voa.db", "S"), tmp_path / "backup.db"
    back_up(url_of(database), file)
    database.write_bytes(b"damaged" * 1000)
    (tmp_path / "voa.db-wal").write_bytes(b"left over")
    restored = restore(file, url_of(database))
    assert restored.kept is not None
    assert restored.kept.read_bytes() == b"damaged" * 1000
    assert not (tmp_path / "voa.db-wal").exists()
    assert versions_of(database, "S") == [0, 1, 2, 3]


def test_a_failed_restore_leaves_the_database_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    database, file = filled(tmp_path / "voa.db", "S"), tmp_path / "backup.db"
    back_up(url_of(database), file)

    def full(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", full)
        with pytest.raises(CannotBackUp, match="No space left"):
            restore(file, url_of(database))
    assert versions_of(database, "S") == [0, 1, 2, 3]
