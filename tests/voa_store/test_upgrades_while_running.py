"""Processes of the version before go on while, and after, their database is migrated to newer tables."""

import itertools
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from alembic import command
from alembic.config import Config
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, inspect, text
from sqlalchemy.exc import OperationalError

from tests.support.postgres import Server
from tests.support.releases import at_revision, load
from tests.support.waiting import wait_for
from tests.voa_store.samples import change, create, engine_of, key, never, next_version, scenario, write
from voa_store import migrate, revisions
from voa_store.engines import connect
from voa_store.errors import CannotOpen
from voa_store.records import StoredResponse
from voa_store.revisions import generation
from voa_store.sql import SqlStore
from voa_store.starting import explain, open_store

FROM = "0009"
"""Newest revision that is not held to the rules: tables of before are those of versions that stop for the upgrade."""
MIGRATIONS = Path(migrate.__file__).parent / "migrations"
FILE = """
import sqlalchemy as sa
from alembic import op
revision, down_revision, branch_labels, depends_on = "{revision}", "{before}", None, None
def upgrade():
    op.add_column("history", sa.Column("more", sa.Text))
    op.add_column("sessions", sa.Column("more", sa.Integer, server_default="7"))
    op.create_table("others", sa.Column("id", sa.Integer, primary_key=True))
"""


def scripts(*more: Path) -> Config:
    """Make a configuration of Alembic with the revisions of this version, and those of other folders."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.set_main_option("path_separator", "newline")
    config.set_main_option("version_locations", "\n".join(map(str, (MIGRATIONS / "versions", *more))))
    return config


@pytest.fixture
def start_newer(database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """A function that migrates the database as a newer version does when it starts."""

    def start(revision: str = "9999", pause: Callable[[float], None] = time.sleep) -> None:
        before = ScriptDirectory.from_config(scripts()).get_current_head()
        (tmp_path / "v_newer.py").write_text(FILE.format(revision=revision, before=before), encoding="utf-8")
        engines = connect(database_url)
        try:
            with monkeypatch.context() as newer:
                newer.setattr(migrate, "_configuration", lambda: scripts(tmp_path))
                newer.setattr(revisions, "REVISIONS", (*revisions.REVISIONS, revision))
                migrate.migrate(engines, pause)
        finally:
            engines.dispose()

    return start


@contextmanager
def writing(store: Any) -> Iterator[list[int]]:
    """Write to session "S" in a thread until the block ends; yields the versions made, and raises what went wrong."""
    made: list[int] = []
    wrong: list[BaseException] = []
    ended = threading.Event()

    def write_on() -> None:
        try:
            while not ended.wait(0.005):  # SQLite lets a second process write only in the gaps between writes
                response = change(store, "S", write(key(f"K{len(made)}")), next_version)
                assert response is not None
                made.append(response.version)
        except BaseException as error:
            wrong.append(error)

    thread = threading.Thread(target=write_on)
    thread.start()
    try:
        wait_for(lambda: len(made) > 3 or wrong, "the first versions")
        yield made
    finally:
        ended.set()
        thread.join()
    assert wrong == []


def test_a_running_process_goes_on_while_a_newer_one_adds_to_the_tables(
    database_url: str, start_newer: Callable[..., None]
) -> None:
    store = SqlStore(database_url)
    store.put_scenario(scenario("A"))
    create(store, "S")
    with writing(store) as made:
        start_newer()
        seen = len(made)
        wait_for(lambda: len(made) > seen + 3, "versions after the migration")
        store.ping()
    assert [entry.state.version for entry in store.history("S", -1, 9_999)] == list(range(len(made) + 1))
    assert store.troubles == 0
    assert change(store, "S", write(key("K0")), never) == StoredResponse("v1", 1)
    assert store.delete_session("S", None, None)
    store.close()
    with pytest.raises(CannotOpen, match=r"written by a newer version of voa .*: start that version, or restore"):
        open_store(database_url)


def test_a_running_process_of_an_earlier_generation_is_not_ready(
    database_url: str, start_newer: Callable[..., None]
) -> None:
    store = SqlStore(database_url)
    start_newer("b9999")
    with pytest.raises(RuntimeError, match="another version of the service has changed the tables"):
        store.ping()
    store.close()


def test_nobody_waits_for_a_migration_that_waits_for_a_backup(postgres: Server) -> None:
    url = postgres.new_database()
    at_revision(url, "0008").dispose()
    dump = engine_of(url)
    engines, times = connect(url), itertools.count()
    with dump.connect() as reading:
        reading.execute(text("LOCK TABLE answers IN ACCESS SHARE MODE"))  # as pg_dump does for as long as it runs
        with pytest.raises(OperationalError, match="lock timeout") as refused:
            migrate.migrate(engines, lambda _: None, lambda: 25.0 * next(times))
    assert next(times) == 4, "tried again for a minute"
    assert "other programs keep its tables locked, a backup perhaps" in explain(refused.value, url)
    migrate.migrate(engines)
    with engines.single.connect() as connection:
        assert revisions.is_current(connection)
    engines.dispose()
    dump.dispose()


class Shape(NamedTuple):
    """Tables as an older version knows them: each column, constraint and index, and the marks of stored rows."""

    columns: dict[str, dict[str, str]]
    others: dict[str, list[str]]
    rows: dict[str, list[str]]


def shape_of(connection: Connection) -> Shape:
    """Read the tables of PostgreSQL. A row's mark is the transaction that wrote it; a table's is its file."""
    seen = inspect(connection)
    names = [name for name in seen.get_table_names() if name != "alembic_version"]
    columns = {
        name: {
            column["name"]: f"{column['type']} {column['nullable'] or column['default'] is not None}"
            for column in seen.get_columns(name)
        }
        for name in names
    }
    listing: list[Callable[[str], Any]] = [
        seen.get_pk_constraint,
        seen.get_foreign_keys,
        seen.get_unique_constraints,
        seen.get_check_constraints,
        seen.get_indexes,
    ]
    others = {name: [str(each(name)) for each in listing] for name in names}
    rows = {
        name: [
            str(connection.execute(text(f"SELECT pg_relation_filenode('{name}')")).scalar_one()),
            *sorted(connection.execute(text(f"SELECT xmin::text || ctid::text FROM {name}")).scalars()),  # noqa: S608 - names from this code alone
        ]
        for name in names
    }
    return Shape(columns, others, rows)


def breaks(before: Shape, after: Shape) -> list[str]:
    """List what a migration does that stops or delays processes of the version before."""
    wrong = []
    for name, columns in before.columns.items():
        now = after.columns.get(name)
        if now is None:
            wrong.append(f"{name} is removed or renamed")
            continue
        wrong += [
            f"{name}.{column} is removed, renamed or changed"
            for column in columns
            if now.get(column) != columns[column]
        ]
        wrong += [
            f"{name}.{column} must be given" for column in now.keys() - columns.keys() if now[column].endswith("False")
        ]
        if before.others[name] != after.others[name]:
            wrong.append(f"constraints or indexes of {name} change")
        if before.rows[name] != after.rows[name]:
            wrong.append(f"rows of {name} are written")
    return wrong


def test_migrations_since_keep_to_the_rules(postgres: Server) -> None:
    directory = ScriptDirectory.from_config(scripts())
    revisions = [script.revision for script in directory.iterate_revisions("head", FROM)][::-1]
    engine = at_revision(postgres.new_database(), FROM)
    previous = FROM
    for revision in revisions:
        with engine.connect() as connection:
            before = shape_of(connection)
        with engine.begin() as connection:
            config = scripts()
            config.attributes["connection"] = connection
            command.upgrade(config, revision)
        with engine.connect() as connection:
            wrong = breaks(before, shape_of(connection))
        assert not wrong or generation(revision) != generation(previous), (
            f"revision {revision}: {wrong}: keep to the rules in CONTRIBUTING.md, or begin a generation"
        )
        previous = revision
    engine.dispose()


@pytest.mark.parametrize(
    ("statement", "wrong"),
    [
        ("ALTER TABLE history ADD COLUMN more text", []),
        ("CREATE TABLE others (id int PRIMARY KEY); CREATE INDEX of_others ON others (id)", []),
        ("ALTER TABLE history ADD COLUMN more text NOT NULL DEFAULT 'x'", []),
        ("ALTER TABLE history RENAME COLUMN request TO body", ["history.request is removed, renamed or changed"]),
        ("ALTER TABLE claims ALTER COLUMN session SET NOT NULL", ["claims.session is removed, renamed or changed"]),
        ("DROP TABLE claims", ["claims is removed or renamed"]),
        ("ALTER TABLE claims ADD COLUMN more text NOT NULL", ["claims.more must be given"]),
        ("CREATE INDEX more ON history (at)", ["constraints or indexes of history change"]),
        ("ALTER TABLE history ADD CHECK (version < 9)", ["constraints or indexes of history change"]),
        ("UPDATE history SET last_fit_rmsd_mm = 0", ["rows of history are written"]),
        ("ALTER TABLE history ADD COLUMN more float DEFAULT random()", ["rows of history are written"]),
    ],
)
def test_the_rules_notice_what_stops_or_delays_an_older_process(
    statement: str, wrong: list[str], loaded: Engine
) -> None:
    with loaded.connect() as connection:
        before = shape_of(connection)
        for each in statement.split("; "):
            connection.execute(text(each))
        assert set(wrong) <= set(breaks(before, shape_of(connection)))
        assert bool(wrong) == bool(breaks(before, shape_of(connection)))
        connection.rollback()


@pytest.fixture(scope="module")
def loaded(postgres: Server) -> Iterator[Engine]:
    """An engine of a database of PostgreSQL with rows in its tables, whose transactions are rolled back."""
    url = postgres.new_database()
    load("0.2.0", url)
    SqlStore(url).close()
    engine = engine_of(url)
    yield engine
    engine.dispose()
