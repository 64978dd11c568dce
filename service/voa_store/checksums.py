"""Checksums of sessions: a row is not believed as read.

SQLite has none of its own, and a disk that flips a bit says nothing. Each row of a history has a checksum over its
columns and the checksum of the version before, so that a row that was changed, swapped, repeated or lost is noticed.
The session's row holds the newest of them and a checksum over its own columns. What these functions compute stands in
every database: it may only ever change together with a migration that fills it in anew.
"""

import hashlib
import zlib
from typing import Any

from sqlalchemy import Row

from voa_service.failures import Damaged, Failure

NOTHING = b""
"""Stands for the checksum before the first version."""

_BYTES = 16


def of_blob(blob: bytes | str | None) -> str:
    """Digest an array or a text once, for every checksum that covers it: its kind, length and CRC-32.

    A CRC notices every flipped bit, and every burst of up to 32; it costs a quarter of what SHA-256 does.
    """
    if blob is None:
        return "none"
    data = blob.encode("utf-8", "surrogateescape") if isinstance(blob, str) else blob
    return f"{type(blob).__name__}:{len(data)}:{zlib.crc32(data):08x}"


def of_entry(before: bytes, entry: Any, belief: str) -> bytes:
    """Compute the checksum of one version of a history.

    Args:
        before: the checksum of the version before; of version 0: `NOTHING`.
        entry: its columns, `session` to `report` and `last_fit_rmsd_mm`.
        belief: the digest of its belief.

    Returns:
        16 bytes.
    """
    request, report = of_blob(entry.request), of_blob(entry.report)
    small = f"{entry.session!r} {entry.version!r} {entry.kind!r} {entry.at!r} {entry.last_fit_rmsd_mm!r}"
    return _of(f"{before.hex()} {small} {request} {report} {belief}")


def of_session(session: Any, newest: bytes, belief: str, prior: str) -> bytes:
    """Compute the checksum of a session's row.

    Args:
        session: its columns, `id`, `scenario`, `version`, `last_fit_rmsd_mm`, `created_at`, `updated_at`, `summary`.
        newest: the checksum of the newest version of its history.
        belief: the digest of its belief.
        prior: the digest of its prior.

    Returns:
        16 bytes.
    """
    small = f"{session.id!r} {session.scenario!r} {session.version!r} {session.last_fit_rmsd_mm!r}"
    times = f"{session.created_at!r} {session.updated_at!r}"
    return _of(f"{newest.hex()} {small} {times} {of_blob(session.summary)} {belief} {prior}")


def check_session(row: Row[Any]) -> str:
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
    return Damaged(
        f"version {version} of session {session!r} is not as it was written: check the disk and all sessions with "
        "`voa doctor --database-url URL`, and restore a backup, or delete the session",
        version=version,
    )


def _of(columns: str) -> bytes:
    return hashlib.sha256(columns.encode("utf-8", "surrogateescape")).digest()[:_BYTES]
