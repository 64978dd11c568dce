"""API keys in the store, in every database: kept for good, revoked once, also beside a running service."""

from contextlib import closing
from dataclasses import replace
from datetime import timedelta

import pytest
from sqlalchemy import text

from tests.voa_store.samples import NOON, Open, engine_of
from voa_service.ports import Store
from voa_store.errors import CannotOpen
from voa_store.records import StoredKey
from voa_store.starting import open_keys

KEY = StoredKey("0123456789ab", bytes(range(32)), "tb3_1", "sensor", NOON)
BOUND = replace(
    KEY,
    id="b",
    name="anna",
    role="operator",
    created_at=NOON + timedelta(days=1),
    sessions=("s1", "s2"),
    robots=(),
    expires_at=NOON + timedelta(days=90),
)


def test_keys_are_listed_as_they_were_put_oldest_first(opened: Open) -> None:
    store: Store = opened()
    assert store.list_keys() == []
    store.put_key(BOUND)
    store.put_key(KEY)
    assert opened().list_keys() == [KEY, BOUND]
    assert "digest" not in repr(KEY)


def test_a_key_is_revoked_once_and_keeps_its_row(opened: Open) -> None:
    store = opened()
    store.put_key(KEY)
    assert not store.revoke_key("b", NOON)
    assert store.revoke_key(KEY.id, NOON)
    assert not store.revoke_key(KEY.id, NOON + timedelta(days=1))
    assert store.list_keys() == [replace(KEY, revoked_at=NOON)]


def test_of_several_processes_the_newest_use_stays(opened: Open) -> None:
    one, two = opened(), opened()
    one.put_key(KEY)
    one.put_key(BOUND)
    after = NOON + timedelta(microseconds=1)
    one.keys_used({KEY.id: after, "unknown": NOON})
    two.keys_used({KEY.id: NOON, BOUND.id: NOON.replace(microsecond=0)})
    two.keys_used({BOUND.id: NOON})
    assert [key.last_used_at for key in one.list_keys()] == [after, NOON]


def test_the_command_s_store_works_beside_that_of_a_service(database_url: str, opened: Open) -> None:
    with closing(open_keys(database_url)) as keys:  # it is the first to open the database
        keys.put_key(KEY)
    store = opened()
    with closing(open_keys(database_url)) as keys:
        keys.put_key(BOUND)
        assert store.list_keys() == keys.list_keys() == [KEY, BOUND]


def test_only_digests_are_stored(database_url: str, opened: Open) -> None:
    opened().put_key(KEY)
    engine = engine_of(database_url)
    with engine.connect() as connection:
        row = connection.execute(text("SELECT * FROM api_keys")).one()
    engine.dispose()
    assert set(row._mapping) == {
        "id",
        "digest",
        "name",
        "role",
        "sessions",
        "robots",
        "created_at",
        "expires_at",
        "revoked_at",
        "last_used_at",
    }
    assert bytes(row.digest) == KEY.digest


def test_a_database_that_cannot_be_used_is_explained_in_one_line() -> None:
    with pytest.raises(CannotOpen, match="there is no folder"):
        open_keys("sqlite:////nowhere/at/all/voa.db")
    with pytest.raises(CannotOpen, match="expected sqlite:///FILE"):
        open_keys("nonsense")
