"""Migrates a database to the tables that this version of the service uses.

Processes of the version before may run while their database is migrated, in a rolling restart. They go on if the
revision keeps to the rules of CONTRIBUTING.md: it only adds tables and nullable columns, and what stays is read and
verified as before. A revision that cannot keep to them begins a generation, a letter before its number ("b0012"):
processes of an earlier generation then report that they are not ready.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import structlog
from sqlalchemy import Connection, text
from sqlalchemy.exc import OperationalError

from voa_store import revisions
from voa_store.engines import Engines
from voa_store.errors import NewerTables

if TYPE_CHECKING:
    from alembic.config import Config

_ONE_AT_A_TIME = 0x766F61  # "voa": the name of PostgreSQL's advisory lock
_MIGRATIONS = Path(__file__).parent / "migrations"
_LOCK_MS = 500
"""Longest wait for the lock of a table: others queue behind it, and PostgreSQL looks for deadlocks after 1 s."""
_LOCKED = ("55P03", "40P01")
"""States of SQL for a lock that could not be had: waited in vain, and deadlock."""
_RETRY_SECONDS = 0.25
_MOST_SECONDS = 60.0


def migrate(
    engines: Engines, pause: Callable[[float], None] = time.sleep, clock: Callable[[], float] = time.monotonic
) -> None:
    """Run the missing migrations in one transaction; processes that start at the same time wait for each other.

    Nothing is written where no migration is missing. While other programs use the tables, processes of the version
    before among them, the transaction gives up soon and is tried again for a minute: nobody waits long for it.

    Args:
        engines: of the database.
        pause: sleeps for so many seconds between two attempts.
        clock: returns the time in seconds.

    Raises:
        NewerTables: a newer version of the service has migrated this database.
        OperationalError: other programs keep tables locked.
    """
    with engines.single.connect() as connection:
        if revisions.is_current(connection):
            return None
    end = clock() + _MOST_SECONDS
    while True:
        try:
            return _migrate(engines)
        except OperationalError as error:
            if getattr(error.orig, "sqlstate", None) not in _LOCKED or clock() >= end:
                raise
            structlog.get_logger("voa").warning("migration waits for tables that others use", why=str(error.orig))
            pause(_RETRY_SECONDS)


def _migrate(engines: Engines) -> None:
    from alembic import command  # noqa: PLC0415 - slow to import, and needed only where a migration is missing

    with engines.writer.begin() as connection, _patient(connection):
        revision = revisions.current(connection)
        if revision is not None and revision not in revisions.REVISIONS:
            raise NewerTables(revision, revisions.newest())
        config = _configuration()
        config.attributes["connection"] = connection
        command.upgrade(config, "head")


@contextmanager
def _patient(connection: Connection) -> Iterator[None]:
    """Wait without time-outs for another process that migrates, and for slow migrations; briefly for each table."""
    if connection.dialect.name != "postgresql":
        yield
        return
    impatient: Any = connection.connection.dbapi_connection
    usual, impatient.patience_s = impatient.patience_s, None
    for name in ("lock_timeout", "statement_timeout"):
        connection.execute(text(f"SET LOCAL {name} = 0"))
    connection.execute(text("SELECT pg_advisory_xact_lock(:name)"), {"name": _ONE_AT_A_TIME})
    connection.execute(text(f"SET LOCAL lock_timeout = {_LOCK_MS}"))
    try:
        yield
    finally:
        impatient.patience_s = usual


def _configuration() -> "Config":
    from alembic.config import Config  # noqa: PLC0415 - slow to import, and needed only where a migration is missing

    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS))
    return config
