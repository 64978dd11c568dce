"""Converts rows of the tables to records of the store, and back."""

import hashlib
from dataclasses import replace
from datetime import datetime
from types import SimpleNamespace
from typing import Any

import numpy as np
from sqlalchemy import Row

from voa_core.filtering import Belief
from voa_core.objects import Object
from voa_store import checksums
from voa_store.errors import DamagedData
from voa_store.records import HistoryEntry, SessionState, StoredObject, StoredScenario, Write

Columns = dict[str, Any]
OF_VERSION = (
    "version",
    "last_fit_rmsd_mm",
    "updated_at",
    "summary",
    "looks",
    "belief",
    "newest",
    "checksum",
    "under_way",
)
"""Columns of a session's row that change with its version."""


def written(
    state: SessionState, write: Write, report: str | None, before: bytes, prior: str
) -> tuple[Columns, Columns]:
    """Convert one version to columns: those of the session's row that change with it, and its row of the history.

    Args:
        state: the session at that version.
        write: the request that made the version.
        report: JSON of the update report; None: the version was not made by an observation.
        before: checksum of the version before; `checksums.NOTHING` for version 0.
        prior: digest of the session's prior.
    """
    belief = blob(state.belief)
    digest = checksums.of_blob(belief)
    fit = None if state.last_fit_rmsd_mm is None else float(state.last_fit_rmsd_mm)
    entry: Columns = {
        "session": state.id,
        "version": state.version,
        "kind": write.kind,
        "at": state.updated_at.isoformat(),
        "request": write.request,
        "report": report,
        "last_fit_rmsd_mm": fit,
        "looks": state.looks,
    }
    newest = checksums.of_entry(before, SimpleNamespace(**entry), digest)
    session: Columns = {
        "id": state.id,
        "scenario": state.scenario,
        "version": state.version,
        "last_fit_rmsd_mm": fit,
        "created_at": state.created_at.isoformat(),
        "updated_at": entry["at"],
        "summary": state.summary,
        "looks": state.looks,
    }
    own = checksums.of_session(SimpleNamespace(**session), newest, digest, prior)
    session |= {"belief": belief, "newest": newest, "checksum": own, "under_way": state.under_way}
    return {name: session[name] for name in OF_VERSION}, entry | {"belief": belief, "checksum": newest}


def blob(belief: Belief) -> bytes:
    """Convert a belief over n poses and its logarithms to bytes: 2 x n little-endian float64."""
    return b"".join(part.astype("<f8", copy=False).tobytes() for part in (belief.p, belief.log_p))


def _belief(stored: bytes) -> Belief:
    p, log_p = np.frombuffer(stored, dtype="<f8").reshape(2, -1)
    return Belief(p, log_p)


def object_of(row: Row[Any]) -> StoredObject:
    """Convert a row of the table `objects` to a mesh.

    Raises:
        DamagedData: its vertices and faces do not have the digest that names them.
    """
    if hashlib.sha256(row.vertices + row.faces).hexdigest() != row.id:
        raise DamagedData(
            f"object {row.id!r} differs from what was written: check the disk and the database with "
            "`voa doctor --database-url URL`, then restore a backup"
        )
    vertices = np.frombuffer(row.vertices, dtype="<f8").reshape(-1, 3)
    faces = np.frombuffer(row.faces, dtype="<i4").reshape(-1, 3)
    return StoredObject(Object(vertices, faces), row.name, datetime.fromisoformat(row.created_at), row.up)


def scenario_of(row: Row[Any]) -> StoredScenario:
    """Convert a row of the table `scenarios` to a scenario."""
    return StoredScenario(row.id, row.name, row.body, datetime.fromisoformat(row.created_at))


def session_of(row: Row[Any]) -> SessionState:
    """Convert a row of the table `sessions`, verified by `checksums.check_session`, to a session."""
    return SessionState(
        row.id,
        row.scenario,
        row.version,
        _belief(row.belief),
        _belief(row.prior),
        row.last_fit_rmsd_mm,
        datetime.fromisoformat(row.created_at),
        datetime.fromisoformat(row.updated_at),
        row.summary,
        row.looks,
        row.under_way,
    )


def entry_of(session: SessionState, row: Row[Any]) -> HistoryEntry:
    """Convert a row of the table `history` to the session's state at that version and the request that made it."""
    state = replace(
        session,
        version=row.version,
        belief=_belief(row.belief),
        last_fit_rmsd_mm=row.last_fit_rmsd_mm,
        updated_at=datetime.fromisoformat(row.at),
        summary=None,
        looks=row.looks,
        under_way=None,
    )
    return HistoryEntry(state, row.kind, row.request, row.report)
