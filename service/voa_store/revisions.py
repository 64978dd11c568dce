"""The revisions of the tables: those that this version of the service knows, and that of a database.

Alembic, which carries out the revisions, is slow to import, and needed only where one is missing. So their names stand
here too.
"""

from typing import Final

from sqlalchemy import Connection, inspect, text

REVISIONS: Final = ("0001", "0002", "0003", "0004", "0005", "0006", "0007", "0008", "0009")
"""Names of all revisions in `migrations/versions`, oldest first."""

_DIGITS = "0123456789"
_TABLE = "alembic_version"
_NAME = text(f"SELECT version_num FROM {_TABLE}")  # noqa: S608 - names from this code alone


def newest() -> str:
    """Return the revision of this version of the service."""
    return REVISIONS[-1]


def current(connection: Connection) -> str | None:
    """Return the revision of the tables of a database; None: it has no tables."""
    if not inspect(connection).has_table(_TABLE):
        return None
    return connection.execute(_NAME).scalar()


def is_current(connection: Connection) -> bool:
    """Return True if the tables are those of this version of the service."""
    return current(connection) == newest()


def can_serve(connection: Connection) -> bool:
    """Return True if this version can work with the tables: its own, or newer ones of the same generation."""
    revision = current(connection)
    if revision is None or revision == newest():
        return revision is not None
    return revision not in REVISIONS and generation(revision) == generation(newest())


def generation(revision: str) -> str:
    """Return the letters before the number of a revision, which a migration that stops older processes changes."""
    return revision.rstrip(_DIGITS)
