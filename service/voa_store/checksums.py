"""Checksums of sessions, by which damaged, swapped, repeated and lost rows are detected.

SQLite has no checksums of its own, and a disk that flips a bit does not report it. Each row of a history has a checksum
over its columns and the checksum of the version before. The session's row holds the newest of them, and a checksum over
its own columns. Every database contains the results of these functions: change them only together with a migration that
computes all checksums again.
"""

import hashlib
import zlib
from typing import Any

from sqlalchemy import Row

from voa_store.errors import DamagedData

NOTHING = b""
"""Placeholder for the checksum of the version before version 0."""

_BYTES = 16


def of_blob(blob: bytes | str | None) -> str:
    """Digest an array or a text by its type, length and CRC-32; one digest serves every checksum that covers it.

    A CRC-32 detects every flipped bit and every burst of up to 32 bits, at a quarter of the cost of SHA-256.
    """
    if blob is None:
        return "none"
    data = blob.encode("utf-8", "surrogateescape") if isinstance(blob, str) else blob
    return f"{type(blob).__name__}:{len(data)}:{zlib.crc32(data):08x}"


def of_entry(before: bytes, entry: Any, belief: str) -> bytes:
    """Compute the checksum of one version of a history.

    Args:
        before: the checksum of the version before; of version 0: `NOTHING`.
        entry: an object with its columns `session` to `report`, `last_fit_rmsd_mm` and `looks` as attributes.
        belief: the digest of its belief.

    Returns:
        16 bytes.
    """
    request, report = of_blob(entry.request), of_blob(entry.report)
    small = f"{entry.session!r} {entry.version!r} {entry.kind!r} {entry.at!r} {entry.last_fit_rmsd_mm!r}"
    return _of(f"{before.hex()} {small} {request} {report} {belief}{_of_looks(entry)}")


def of_session(session: Any, newest: bytes, belief: str, prior: str) -> bytes:
    """Compute the checksum of a session's row.

    Args:
        session: an object with the columns `id`, `scenario`, `version`, `last_fit_rmsd_mm`, `created_at`, `updated_at`,
            `summary` and `looks` as attributes.
        newest: the checksum of the newest version of its history.
        belief: the digest of its belief.
        prior: the digest of its prior.

    Returns:
        16 bytes.
    """
    small = f"{session.id!r} {session.scenario!r} {session.version!r} {session.last_fit_rmsd_mm!r}"
    times = f"{session.created_at!r} {session.updated_at!r}"
    return _of(f"{newest.hex()} {small} {times} {of_blob(session.summary)} {belief} {prior}{_of_looks(session)}")


def check_session(row: Row[Any]) -> str:
    """Verify a session's row; returns the digest of its prior, which never changes.

    Raises:
        DamagedData: the row differs from what was written.
    """
    prior = of_blob(row.prior)
    if row.newest is None or row.checksum != of_session(row, row.newest, of_blob(row.belief), prior):
        raise damaged(row.id, row.version)
    return prior


def damaged(session: str, version: int) -> DamagedData:
    """Build the error that reports a damaged version of a session."""
    return DamagedData(
        f"version {version} of session {session!r} differs from what was written: check the disk and all sessions with "
        "`voa doctor --database-url URL`, then restore a backup or delete the session",
        version,
    )


def _of_looks(row: Any) -> str:
    """Digest the column `looks`; rows without looks, and those from before that column, have no such digest."""
    looks = getattr(row, "looks", None)
    return "" if looks is None else f" {of_blob(looks)}"


def _of(columns: str) -> bytes:
    return hashlib.sha256(columns.encode("utf-8", "surrogateescape")).digest()[:_BYTES]
