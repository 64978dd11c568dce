"""A session that is not as it was written is noticed, named, and alone in that."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text

from tests.voa_store.samples import change, create, engine_of, looking, next_version, scenario, write
from voa_service.ports import Store
from voa_store.engines import connect
from voa_store.errors import DamagedData
from voa_store.sql import SqlStore
from voa_store.verify import Verified, main, verify_all

VERSIONS = 9


@pytest.fixture
def long(store: Store) -> Store:
    """A store with the sessions S and T of ten versions each."""
    for id_ in ("S", "T"):
        create(store, id_)
        for number in range(VERSIONS):
            change(store, id_, write(request=f'"{id_}{number}"'), looking(f'{{"since": {10 * number}}}'))
    return store


def spoil(url: str, statement: str, **named: Any) -> None:
    """Change rows behind the store's back."""
    engine = engine_of(url)
    with engine.begin() as connection:
        assert connection.execute(text(statement), named).rowcount > 0
    engine.dispose()


def flipped(url: str, query: str) -> bytes:
    """A blob with one bit changed."""
    engine = engine_of(url)
    with engine.begin() as connection:
        blob = bytearray(connection.execute(text(query)).scalar_one())
    engine.dispose()
    blob[11] ^= 4
    return bytes(blob)


def damaged_version(call: Callable[[], object]) -> int | None:
    with pytest.raises(DamagedData) as refused:
        call()
    return refused.value.version


def verified(url: str) -> Verified:
    engines = connect(url)
    try:
        return verify_all(engines)
    finally:
        engines.dispose()


@pytest.mark.parametrize("column", ["belief", "prior"])
def test_a_bit_of_a_sessions_own_row_is_noticed_and_others_go_on(long: Store, database_url: str, column: str) -> None:
    changed = flipped(database_url, f"SELECT {column} FROM sessions WHERE id = 'S'")  # noqa: S608 - our names
    spoil(database_url, f"UPDATE sessions SET {column} = :changed WHERE id = 'S'", changed=changed)  # noqa: S608
    for call in (
        lambda: long.get_session("S"),
        lambda: long.history("S", -1, 5),
        lambda: change(long, "S", write(), next_version),
    ):
        assert damaged_version(call) == VERSIONS
    assert long.get_session("T") is not None
    assert len(long.history("T", -1, 99)) == VERSIONS + 1
    assert [item.id for item in long.list_sessions(9, None).items] == ["S", "T"]
    assert [(each.session, each.version) for each in verified(database_url).damaged] == [("S", VERSIONS)]
    assert long.delete_session("S", None, None), "a damaged session can be deleted"
    assert verified(database_url).well


@pytest.mark.parametrize(
    "assignment",
    [
        "scenario = 'A', version = version + 1",
        "last_fit_rmsd_mm = 1.5",
        "updated_at = '2026-01-02T12:00:00.000001+00:00'",
        "created_at = '2026-01-02T12:00:00.000001+00:00'",
        "summary = '{}'",
        "looks = NULL",
        "looks = '{\"since\": 1}'",
        "newest = checksum",
        "checksum = NULL",
    ],
)
def test_every_column_of_a_session_is_covered(long: Store, database_url: str, assignment: str) -> None:
    spoil(database_url, f"UPDATE sessions SET {assignment} WHERE id = 'S'")  # noqa: S608 - our names
    assert damaged_version(lambda: long.get_session("S")) is not None


@pytest.mark.parametrize(
    "assignment",
    [
        "kind = 'belief'",
        "at = '2026-01-02T12:00:00.000001+00:00'",
        "request = '\"S4 \"'",
        "report = NULL",
        "last_fit_rmsd_mm = 0.0",
        "looks = NULL",
        "looks = '{\"since\": 1}'",
        "checksum = NULL",
    ],
)
def test_every_column_of_a_version_is_covered_and_the_version_named(
    long: Store, database_url: str, assignment: str
) -> None:
    spoil(database_url, f"UPDATE history SET {assignment} WHERE session = 'S' AND version = 4")  # noqa: S608
    assert damaged_version(lambda: long.history("S", -1, 99)) == 4
    assert len(long.history("S", -1, 4)) == 4, "what comes before is right"
    assert long.get_session("S") is not None
    assert change(long, "S", write(), next_version) is not None
    assert [(each.session, each.version) for each in verified(database_url).damaged] == [("S", 4)]


def test_a_flipped_bit_of_a_belief_in_the_history_is_noticed(long: Store, database_url: str) -> None:
    changed = flipped(database_url, "SELECT belief FROM history WHERE session = 'S' AND version = 6")
    spoil(database_url, "UPDATE history SET belief = :changed WHERE session = 'S' AND version = 6", changed=changed)
    assert damaged_version(lambda: long.history("S", 5, 1)) == 6
    assert [entry.state.version for entry in long.history("S", 7, 9)] == [8, 9]


@pytest.mark.parametrize("missing", [0, 4, VERSIONS])
def test_a_version_that_is_missing_is_named(long: Store, database_url: str, missing: int) -> None:
    spoil(database_url, "DELETE FROM history WHERE session = 'S' AND version = :missing", missing=missing)
    assert damaged_version(lambda: long.history("S", -1, 99)) == missing
    assert [each.version for each in verified(database_url).damaged] == [missing]


def test_versions_of_two_sessions_cannot_be_exchanged(long: Store, database_url: str) -> None:
    spoil(
        database_url,
        "UPDATE history SET (request, checksum) = "
        "(SELECT request, checksum FROM history WHERE session = 'T' AND version = 3) "
        "WHERE session = 'S' AND version = 3",
    )
    assert damaged_version(lambda: long.history("S", -1, 99)) == 3


def test_text_that_is_none_any_more_is_damage(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    store = SqlStore(url)
    store.put_scenario(scenario("A"))
    create(store)
    spoil(url, "UPDATE history SET request = CAST(x'7bff7d' AS TEXT) WHERE version = 0")
    assert damaged_version(lambda: store.history("S", -1, 9)) == 0
    store.close()


def test_verify_counts_what_is_right_and_prints_json(
    long: Store, database_url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([database_url]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["sessions"], report["versions"], report["damaged"]) == (2, 2 * (VERSIONS + 1), [])
    assert report["database"] == long.software
    spoil(database_url, "UPDATE history SET request = '' WHERE session = 'T' AND version = 2")
    assert main([database_url]) == 1
    (damage,) = json.loads(capsys.readouterr().out)["damaged"]
    assert (damage["session"], damage["version"]) == ("T", 2)


@pytest.mark.parametrize("url", ["sqlite:////nowhere/voa.db", "mysql://x/y", "postgresql://voa@127.0.0.1:1/voa"])
def test_verify_says_why_it_cannot_read(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([url]) == 2
    assert json.loads(capsys.readouterr().out)["error"]


def test_announced_looks_are_covered_by_no_checksum(long: Store, database_url: str) -> None:
    spoil(database_url, "UPDATE sessions SET under_way = '[]' WHERE id = 'S'")
    state = long.get_session("S")
    assert state is not None
    assert state.under_way == "[]"
    assert verified(database_url).well


@pytest.mark.parametrize("table", ["sessions", "history"])
def test_looks_in_a_row_that_had_none_are_damage(
    long: Store, database_url: str, table: str, capsys: pytest.CaptureFixture[str]
) -> None:
    create(long, "U")
    assert main([database_url]) == 0
    capsys.readouterr()
    column = "id" if table == "sessions" else "session"
    spoil(database_url, f"UPDATE {table} SET looks = '' WHERE {column} = 'U'")  # noqa: S608 - our names
    assert main([database_url]) == 1
    (damage,) = json.loads(capsys.readouterr().out)["damaged"]
    assert (damage["session"], damage["version"]) == ("U", 0)
