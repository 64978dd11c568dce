"""Checksums of sessions: a row is not believed as read.

SQLite has none of its own, and a disk that flips a bit says nothing. Each row of a history has a checksum over its
columns and the checksum of the version before, so that a row that was changed, swapped, repeated or lost is noticed.
The session's row holds the newest of them and a checksum over its own columns. What these functions compute stands in
every database: it may only ever change together with a migration that fills it in anew.
"""

import hashlib
import struct
from typing import Any

from sqlalchemy import Row

from voa_service.failures import DAMAGED, Failure

NOTHING = b""
"""Stands for the checksum before the first version, and for the blob that a column should have and has not."""

_BYTES = 16
_FLOAT = struct.Struct("<d")


def of_blob(blob: bytes | None) -> bytes:
    """Digest an array once, for every checksum that covers it (SHA-256: hardware computes it)."""
    return hashlib.sha256(NOTHING if blob is None else blob).digest()


def of_entry(before: bytes, entry: Any, belief: bytes) -> bytes:
    """Compute the checksum of one version of a history.

    Args:
        before: the checksum of the version before; of version 0: `NOTHING`.
        entry: its columns, `session` to `report` and `last_fit_rmsd_mm`.
        belief: the digest of its belief.

    Returns:
        16 bytes.
    """
    return _of(
        before,
        entry.session,
        entry.version,
        entry.kind,
        entry.at,
        entry.request,
        entry.report,
        entry.last_fit_rmsd_mm,
        belief,
    )


def of_session(session: Any, newest: bytes, belief: bytes, prior: bytes) -> bytes:
    """Compute the checksum of a session's row.

    Args:
        session: its columns, `id`, `scenario`, `version`, `last_fit_rmsd_mm`, `created_at`, `updated_at`, `summary`.
        newest: the checksum of the newest version of its history.
        belief: the digest of its belief.
        prior: the digest of its prior.

    Returns:
        16 bytes.
    """
    return _of(
        newest,
        session.id,
        session.scenario,
        session.version,
        session.last_fit_rmsd_mm,
        session.created_at,
        session.updated_at,
        session.summary,
        belief,
        prior,
    )


def check_session(row: Row[Any]) -> bytes:
    """Verify a session's row; returns the digest of its prior, which never changes.

    Raises:
        Failure: the row is not as it was written.
    """
    prior = of_blob(row.prior)
    if row.newest is None or row.checksum != of_session(row, row.newest, of_blob(row.belief), prior):
        raise damaged(row.id, row.version)
    return prior


def damaged(session: str, version: int) -> Failure:
    """Report that a version of a session is not as it was written."""
    return Failure(
        DAMAGED,
        f"version {version} of session {session!r} is not as it was written: check the disk and all sessions with "
        "`voa doctor --database-url URL`, and restore a backup, or delete the session",
        version=version,
    )


def _of(*values: bytes | str | float | None) -> bytes:
    hasher = hashlib.sha256()
    for value in values:
        kind, data = _encoded(value)
        hasher.update(b"%c%d:" % (kind, len(data)) + data)
    return hasher.digest()[:_BYTES]


def _encoded(value: bytes | str | float | None) -> tuple[bytes, bytes]:
    """Write a column as its kind and its bytes; a column of another type than it had gives other ones."""
    if value is None:
        return b"n", NOTHING
    if isinstance(value, str):
        return b"s", value.encode("utf-8", "surrogateescape")
    if isinstance(value, bytes):
        return b"b", value
    if isinstance(value, int):
        return b"i", b"%d" % value
    return b"f", _FLOAT.pack(value)
