"""Carries API keys from a database into the backup that replaces it, so that no restored key outlives its revocation.

Keys must not go back in time with the rest of a database: a backup alone would make keys valid that were revoked since,
lack those that were made since, and open the service if it was made before the first key.
"""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from voa_store.drivers import sqlite_driver
from voa_store.tables import api_keys

_COLUMNS = tuple(column.name for column in api_keys.c)
_TABLE = api_keys.name
_HAS_TABLE = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?"
# The names are those of this package's own tables.
_INSERT = f"INSERT OR IGNORE INTO {_TABLE} ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))})"  # noqa: S608 - names from this code alone
_REVOKE = f"UPDATE {_TABLE} SET revoked_at = ? WHERE id = ? AND revoked_at IS NULL"  # noqa: S608 - names from this code alone
_USE = f"UPDATE {_TABLE} SET last_used_at = ? WHERE id = ? AND coalesce(last_used_at, '') < ?"  # noqa: S608 - names from this code alone
_VALID = f"SELECT count(*) FROM {_TABLE} WHERE revoked_at IS NULL"  # noqa: S608 - names from this code alone
_ALL = f"SELECT count(*) FROM {_TABLE}"  # noqa: S608 - names from this code alone


@dataclass(frozen=True)
class CarriedKeys:
    """Keys of a restored database.

    Attributes:
        before: `read`: the keys of the database that was replaced were carried over; `none`: there was no database;
            `unreadable`: its keys could not be read.
        carried: number of keys that the backup lacked.
        revoked: number of keys of the backup that were revoked since.
        all: number of keys of the restored database.
        unrevoked: number of these that nobody has revoked.
    """

    before: Literal["read", "none", "unreadable"]
    carried: int
    revoked: int
    all: int
    unrevoked: int


def carry_keys(before: Path | None, restored: Path) -> CarriedKeys:
    """Add the keys and revocations of a database to the one that replaces it.

    Args:
        before: database that is replaced, which no process has open; None: there is none.
        restored: database that replaces it, with the tables of this version.

    Raises:
        sqlite3.Error: the restored database cannot be written.
    """
    rows = [] if before is None else _rows(before)
    with closing(sqlite_driver().connect(str(restored))) as connection:
        with connection:
            done = [_carry(connection, row) for row in rows or ()]
        unrevoked, every = (connection.execute(query).fetchone()[0] for query in (_VALID, _ALL))
    state: Literal["read", "none", "unreadable"] = (
        "none" if before is None else "unreadable" if rows is None else "read"
    )
    return CarriedKeys(state, done.count("carried"), done.count("revoked"), every, unrevoked)


def _carry(connection: Any, row: Mapping[str, Any]) -> Literal["carried", "revoked", "known"]:
    """Add a key to a database, or its revocation and last use where the database knows it."""
    if connection.execute(_INSERT, [row.get(name) for name in _COLUMNS]).rowcount == 1:
        return "carried"
    id_, used, revoked = row["id"], row.get("last_used_at"), row.get("revoked_at")
    if used is not None:
        connection.execute(_USE, (used, id_, used))
    if revoked is not None and connection.execute(_REVOKE, (revoked, id_)).rowcount == 1:
        return "revoked"
    return "known"


def _rows(database: Path) -> list[dict[str, Any]] | None:
    """Read the keys of a database, whichever version of the service made its tables; None: they cannot be read."""
    driver = sqlite_driver()
    try:
        with closing(driver.connect(f"file:{quote(str(database))}?mode=ro", uri=True)) as connection:
            if not connection.execute(_HAS_TABLE, (_TABLE,)).fetchone()[0]:
                return []
            cursor = connection.execute(f"SELECT * FROM {_TABLE}")  # noqa: S608 - names from this code alone
            names = [column[0] for column in cursor.description]
            return [dict(zip(names, row, strict=True)) for row in cursor]
    except driver.Error:
        return None
