"""Brings a database to the tables that this version of the service knows."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, text

from voa_store.engines import Engines


class NewerTables(Exception):
    """The tables are those of a later version of the service."""

    def __init__(self, found: str, newest: str) -> None:
        super().__init__(f"its tables are of revision {found}, this version knows those up to {newest}")


_ONE_AT_A_TIME = 0x766F61  # "voa": the name of PostgreSQL's advisory lock
_REVISIONS = Path(__file__).parent / "migrations"


def migrate(engines: Engines) -> None:
    """Run what is missing, in one transaction; processes that start at the same time wait for each other.

    Where nothing is missing nothing is written.

    Raises:
        NewerTables: a later version of the service has used this database.
    """
    with engines.single.connect() as connection:
        if _current(connection) == _newest():
            return
    with engines.writer.begin() as connection, _patient(connection):
        found = _current(connection)
        if found is not None and found not in _known():
            raise NewerTables(found, _newest())
        config = Config()
        config.set_main_option("script_location", str(_REVISIONS))
        config.attributes["connection"] = connection
        command.upgrade(config, "head")


@contextmanager
def _patient(connection: Connection) -> Iterator[None]:
    """Wait for another process that migrates, and for slow steps, as long as they take."""
    if connection.dialect.name != "postgresql":
        yield
        return
    impatient: Any = connection.connection.dbapi_connection
    usual, impatient.patience_s = impatient.patience_s, None
    for name in ("lock_timeout", "statement_timeout"):
        connection.execute(text(f"SET LOCAL {name} = 0"))
    connection.execute(text("SELECT pg_advisory_xact_lock(:name)"), {"name": _ONE_AT_A_TIME})
    try:
        yield
    finally:
        impatient.patience_s = usual


def is_current(connection: Connection) -> bool:
    """Whether the tables are those of this version."""
    return _current(connection) == _newest()


def _current(connection: Connection) -> str | None:
    return MigrationContext.configure(connection).get_current_revision()


def _newest() -> str:
    return str(_scripts().get_current_head())


def _known() -> set[str]:
    return {script.revision for script in _scripts().walk_revisions()}


def _scripts() -> ScriptDirectory:
    config = Config()
    config.set_main_option("script_location", str(_REVISIONS))
    return ScriptDirectory.from_config(config)
