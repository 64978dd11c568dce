"""Reading the history of a session, in pages bounded in bytes, each verified from the version before it."""

from typing import Any

from sqlalchemy import Connection, Row, bindparam, select

from voa_service.ports import HistoryEntry
from voa_store import checksums
from voa_store.rows import entry_of, session_of
from voa_store.tables import history as table

_START = -1
_FIRST_ROWS, _MOST_ROWS = 4, 64

_CHECKSUM = select(table.c.checksum).where(
    table.c.session == bindparam("by_id"), table.c.version == bindparam("by_version")
)
_ROWS = (
    select(table)
    .where(table.c.session == bindparam("by_id"), table.c.version > bindparam("by_version"))
    .order_by(table.c.version)
    .limit(bindparam("by_limit"))
)


def read_history(
    connection: Connection, session: Row[Any], after: int, limit: int, most_bytes: int | None
) -> list[HistoryEntry]:
    """Read versions of a session above `after`, ascending, within a transaction that sees one state of the database.

    Args:
        connection: of the transaction.
        session: the session's row, verified.
        after: a version; -1 or less begins with the prior.
        limit: at most so many versions.
        most_bytes: no more once requests, reports and beliefs have so many; at least one version comes. None: no bound.

    Raises:
        Failure: a version is not as it was written, or is missing.
    """
    seen = max(after, _START)
    state, found = session_of(session), list[HistoryEntry]()
    before, held, rows = checksums.NOTHING, 0, _FIRST_ROWS
    if _START < seen < session.version:
        before = _checksum(connection, session.id, seen)
    while seen < session.version and len(found) < limit:
        named = {"by_id": session.id, "by_version": seen, "by_limit": min(rows, limit - len(found))}
        for row in connection.execute(_ROWS, named).all():
            before = verified(row, seen, before, session)
            seen, held = row.version, held + _size(row)
            found.append(entry_of(state, row))
            if most_bytes is not None and held >= most_bytes:
                return found
        if seen < named["by_version"] + named["by_limit"] and seen < session.version:
            raise checksums.damaged(session.id, seen + 1)
        rows = min(2 * rows, _MOST_ROWS) if most_bytes is None else _next_rows(rows, held, len(found), most_bytes)
    return found


def verified(row: Row[Any], before: int, checksum: bytes, session: Row[Any]) -> bytes:
    """Verify one version of a history; returns its checksum.

    Args:
        row: of the history.
        before: the version before it.
        checksum: that version's.
        session: the session's row, verified.

    Raises:
        Failure: the row is not as it was written, or one is missing before it.
    """
    if row.version != before + 1:
        raise checksums.damaged(session.id, before + 1)
    own = checksums.of_entry(checksum, row, checksums.of_blob(row.belief))
    if row.checksum != own or (row.version == session.version and own != session.newest):
        raise checksums.damaged(session.id, row.version)
    return own


def _checksum(connection: Connection, id_: str, version: int) -> bytes:
    found: bytes | None = connection.execute(_CHECKSUM, {"by_id": id_, "by_version": version}).scalar_one_or_none()
    if found is None:
        raise checksums.damaged(id_, version)
    return found


def _size(row: Row[Any]) -> int:
    return len(row.request) + len(row.report or "") + len(row.belief)


def _next_rows(rows: int, held: int, read: int, most_bytes: int) -> int:
    """Ask for as many rows as probably fit, and not for many more than were asked for before."""
    return max(1, min(2 * rows, _MOST_ROWS, (most_bytes - held) * read // max(held, 1) + 1))
