"""Databases that earlier releases have written, with the calls and responses of their sessions."""

import json
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Engine, text

from tests.voa_store.samples import engine_of
from voa_store import migrate
from voa_store.drivers import sqlite_driver

_FOLDER = Path(__file__).parents[1] / "voa_store" / "releases"
VERSIONS = ("0.1.0", "0.2.0")
_COUNTED = ("objects", "scenarios", "sessions")
"""Tables whose rows PostgreSQL counts up."""
_IN_ORDER = ("objects", "scenarios", "sessions", "history")
"""Tables that others refer to come first."""


@dataclass(frozen=True)
class Call:
    """A call that an earlier release has answered.

    Attributes:
        method: of HTTP.
        path: of HTTP.
        body: of the request; None: it had none.
        key: its idempotency key; None: it had none.
        status: of the response.
        response: body of the response.
    """

    method: str
    path: str
    body: str | None
    key: str | None
    status: int
    response: str


def calls(version: str) -> list[Call]:
    """Read the calls that a release has answered, in their order."""
    return [Call(**call) for call in json.loads((_FOLDER / version / "calls.json").read_text(encoding="utf-8"))]


def dump(version: str) -> str:
    """Read the database of a release as SQL text of SQLite."""
    return (_FOLDER / version / "database.sql").read_text(encoding="utf-8")


def load(version: str, url: str) -> None:
    """Write the database of a release into an empty one.

    On SQLite its own text is run. On PostgreSQL the release's migrations make the tables, and its rows are inserted.
    """
    if url.startswith("sqlite"):
        file = Path(url.removeprefix("sqlite:///"))
        with closing(sqlite_driver().connect(str(file))) as connection:
            connection.executescript(dump(version))
        return
    with closing(sqlite3.connect(":memory:")) as rows:
        rows.executescript(dump(version))
        rows.row_factory = sqlite3.Row
        (revision,) = rows.execute("SELECT version_num FROM alembic_version").fetchone()
        engine = at_revision(url, revision)
        names = [name for (name,) in rows.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        with engine.begin() as connection:
            for name in sorted(set(names) - {"alembic_version", "sqlite_sequence"}, key=_order):
                for row in map(dict, rows.execute(f'SELECT * FROM "{name}"')):  # noqa: S608 - a name of our own
                    columns, values = (", ".join(form.format(each) for each in row) for form in ('"{}"', ":{}"))
                    connection.execute(text(f'INSERT INTO "{name}" ({columns}) VALUES ({values})'), row)  # noqa: S608 - names from this code alone
            for name in _COUNTED:
                newest = f"SELECT coalesce(max(seq), 1) FROM {name}"  # noqa: S608 - a name of our own
                connection.execute(text(f"SELECT setval(pg_get_serial_sequence('{name}', 'seq'), ({newest}))"))
        engine.dispose()


def _order(table: str) -> int:
    return _IN_ORDER.index(table) if table in _IN_ORDER else len(_IN_ORDER)


def at_revision(url: str, revision: str) -> Engine:
    """Create the tables that an earlier version had, empty; return an engine that the caller disposes of."""
    engine = engine_of(url)
    with engine.begin() as connection:
        config = Config()
        config.set_main_option("script_location", str(Path(migrate.__file__).parent / "migrations"))
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
    return engine
