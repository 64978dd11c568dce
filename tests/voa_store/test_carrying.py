"""Keys do not go back in time with a database: a restoration keeps revocations, and keys that the backup lacks."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest
from sqlalchemy import text

from tests.support.releases import at_revision
from tests.voa_store.samples import NOON, engine_of
from tests.voa_store.test_backups import url_of
from tests.voa_store.test_keys import KEY
from voa_store.backups import back_up, restore
from voa_store.carrying import CarriedKeys
from voa_store.records import StoredKey
from voa_store.starting import open_keys

NEXT_DAY = NOON + timedelta(days=1)
NEWER = replace(KEY, id="newer", name="tb3_2", created_at=NEXT_DAY, robots=("tb3_2",))


def put(database: Path, *keys: StoredKey) -> None:
    with closing(open_keys(url_of(database))) as store:
        for key in keys:
            store.put_key(key)


def revoke(database: Path, *ids: str) -> None:
    with closing(open_keys(url_of(database))) as store:
        assert all(store.revoke_key(id_, NEXT_DAY) for id_ in ids)


def keys_of(database: Path) -> Sequence[StoredKey]:
    with closing(open_keys(url_of(database))) as store:
        return store.list_keys()


@pytest.fixture
def database(tmp_path: Path) -> Path:
    """Database with a key, of which there is a backup."""
    put(tmp_path / "voa.db", KEY)
    back_up(url_of(tmp_path / "voa.db"), tmp_path / "backup.db")
    return tmp_path / "voa.db"


@pytest.fixture
def backup(database: Path) -> Path:
    return database.with_name("backup.db")


def test_a_key_that_was_revoked_since_the_backup_stays_revoked(database: Path, backup: Path) -> None:
    revoke(database, KEY.id)
    assert restore(backup, url_of(database)).keys == CarriedKeys("read", 0, 1, 1, 0)
    assert keys_of(database) == [replace(KEY, revoked_at=NEXT_DAY)]


def test_a_key_that_was_made_since_the_backup_stays(database: Path, backup: Path) -> None:
    put(database, NEWER)
    with closing(open_keys(url_of(database))) as store:
        store.keys_used({KEY.id: NEXT_DAY})
    assert restore(backup, url_of(database)).keys == CarriedKeys("read", 1, 0, 2, 2)
    assert keys_of(database) == [replace(KEY, last_used_at=NEXT_DAY), NEWER]


def test_a_newer_backup_keeps_its_own_revocations(database: Path, backup: Path) -> None:
    """A person restores an old backup first, and then the one of a moment ago."""
    put(database, NEWER)
    revoke(database, KEY.id)
    late = back_up(url_of(database), backup.with_name("late.db")).file
    database.unlink()
    restore(backup, url_of(database))
    assert restore(late, url_of(database)).keys == CarriedKeys("read", 0, 0, 2, 1)
    assert keys_of(database) == [replace(KEY, revoked_at=NEXT_DAY), NEWER]


def test_a_backup_from_before_the_first_key_does_not_open_the_service(tmp_path: Path) -> None:
    database, backup = tmp_path / "voa.db", tmp_path / "old.db"
    put(database)
    back_up(url_of(database), backup)
    put(database, KEY)
    revoke(database, KEY.id)
    assert restore(backup, url_of(database)).keys == CarriedKeys("read", 1, 0, 1, 0)
    assert keys_of(database) == [replace(KEY, revoked_at=NEXT_DAY)]


def test_tables_of_other_versions_are_read_as_they_are(tmp_path: Path, backup: Path) -> None:
    at_revision(url_of(tmp_path / "old.db"), "0001").dispose()
    assert restore(backup, url_of(tmp_path / "old.db")).keys == CarriedKeys("read", 0, 0, 1, 1)
    newer = tmp_path / "newer.db"
    put(newer, NEWER)
    engine = engine_of(url_of(newer))
    with engine.begin() as connection:
        connection.execute(text("ALTER TABLE api_keys ADD COLUMN note TEXT"))
    engine.dispose()
    assert restore(backup, url_of(newer)).keys == CarriedKeys("read", 1, 0, 2, 2)
    assert keys_of(newer) == [KEY, NEWER]


def test_where_there_is_nothing_to_carry_that_is_reported(database: Path, backup: Path) -> None:
    elsewhere = database.with_name("elsewhere.db")
    assert restore(backup, url_of(elsewhere)).keys == CarriedKeys("none", 0, 0, 1, 1)
    database.write_bytes(b"no database at all" * 100)
    assert restore(backup, url_of(database)).keys == CarriedKeys("unreadable", 0, 0, 1, 1)
