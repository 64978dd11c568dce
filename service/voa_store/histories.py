"""Reads the history of a session in pages bounded in bytes; each version is verified against the one before it."""

from typing import Any

from sqlalchemy import Connection, Row, bindparam, select

from voa_store import checksums
from voa_store.records import HistoryEntry
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
        limit: most versions to read.
        most_bytes: reading stops, after at least one version, once requests, reports and beliefs add up to so many
            bytes; None: no bound.

    Raises:
        DamagedData: a version differs from what was written, or is missing.
    """
    seen = max(after, _START)
    state, entries = session_of(session), list[HistoryEntry]()
    before, held, rows = checksums.NOTHING, 0, _FIRST_ROWS
    if _START < seen < session.version:
        before = _checksum(connection, session.id, seen)
    while seen < session.version and len(entries) < limit:
        named = {"by_id": session.id, "by_version": seen, "by_limit": min(rows, limit - len(entries))}
        for row in connection.execute(_ROWS, named).all():
            before = verified(row, seen, before, session)
            seen, held = row.version, held + _size(row)
            entries.append(entry_of(state, row))
            if most_bytes is not None and held >= most_bytes:
                return entries
        if seen < named["by_version"] + named["by_limit"] and seen < session.version:
            raise checksums.damaged(session.id, seen + 1)
        rows = min(2 * rows, _MOST_ROWS) if most_bytes is None else _next_rows(rows, held, len(entries), most_bytes)
    return entries


def verified(row: Row[Any], before: int, checksum: bytes, session: Row[Any]) -> bytes:
    """Verify a version of a history; returns its checksum.

    Args:
        row: the version's row.
        before: number of the version before it.
        checksum: checksum of the version before it.
        session: the session's row, verified.

    Raises:
        DamagedData: the row differs from what was written, one before it is missing, or the session's own row is older.
    """
    if row.version != before + 1 or row.version > session.version:
        raise checksums.damaged(session.id, before + 1)
    own = checksums.of_entry(checksum, row, checksums.of_blob(row.belief))
    if row.checksum != own or (row.version == session.version and own != session.newest):
        raise checksums.damaged(session.id, row.version)
    return own


def _checksum(connection: Connection, id_: str, version: int) -> bytes:
    checksum: bytes | None = connection.execute(_CHECKSUM, {"by_id": id_, "by_version": version}).scalar_one_or_none()
    if checksum is None:
        raise checksums.damaged(id_, version)
    return checksum


def _size(row: Row[Any]) -> int:
    return len(row.request) + len(row.report or "") + len(row.belief) + len(row.looks or "")


def _next_rows(rows: int, held: int, read: int, most_bytes: int) -> int:
    """Return how many rows to read next: as many as probably fit, and at most twice as many as before."""
    return max(1, min(2 * rows, _MOST_ROWS, (most_bytes - held) * read // max(held, 1) + 1))
