"""Rows as what the ports speak of, and back."""

from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np
from sqlalchemy import Row

from voa_core.filtering import Belief
from voa_core.objects import Object
from voa_service.ports import HistoryEntry, SessionState, StoredObject, StoredScenario


def session_columns(state: SessionState) -> dict[str, Any]:
    """Write the columns of a session that change with its version."""
    return {
        "version": state.version,
        "belief": blob(state.belief),
        "prior": blob(state.prior),
        "last_fit_rmsd_mm": state.last_fit_rmsd_mm,
        "created_at": state.created_at.isoformat(),
        "updated_at": state.updated_at.isoformat(),
    }


def blob(belief: Belief) -> bytes:
    """Write a belief and its logarithms as 2 x n little-endian float64."""
    return np.stack([belief.p, belief.log_p]).astype("<f8").tobytes()


def _belief(stored: bytes) -> Belief:
    p, log_p = np.frombuffer(stored, dtype="<f8").reshape(2, -1)
    return Belief(p, log_p)


def object_of(row: Row[Any]) -> StoredObject:
    """Read a mesh."""
    vertices = np.frombuffer(row.vertices, dtype="<f8").reshape(-1, 3)
    faces = np.frombuffer(row.faces, dtype="<i4").reshape(-1, 3)
    return StoredObject(Object(vertices, faces), row.name, datetime.fromisoformat(row.created_at), row.up)


def scenario_of(row: Row[Any]) -> StoredScenario:
    """Read a scenario."""
    return StoredScenario(row.id, row.name, row.body, datetime.fromisoformat(row.created_at))


def session_of(row: Row[Any]) -> SessionState:
    """Read a session as it stands."""
    return SessionState(
        row.id,
        row.scenario,
        row.version,
        _belief(row.belief),
        _belief(row.prior),
        row.last_fit_rmsd_mm,
        datetime.fromisoformat(row.created_at),
        datetime.fromisoformat(row.updated_at),
    )


def entry_of(session: SessionState, row: Row[Any]) -> HistoryEntry:
    """Read one version of a session's history: the session as it was then, and what made it."""
    then = replace(
        session,
        version=row.version,
        belief=_belief(row.belief),
        last_fit_rmsd_mm=row.last_fit_rmsd_mm,
        updated_at=datetime.fromisoformat(row.at),
    )
    return HistoryEntry(then, row.kind, row.request, row.report)
