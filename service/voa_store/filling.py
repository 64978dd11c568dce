"""Values that migration 0006 computes for existing rows: checksums of sessions, and summaries for lists.

The statements name the columns that the tables have at that migration; tables of newer versions have others.
"""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
from sqlalchemy import Connection, Row, text

from voa_core.objects import Object
from voa_store import checksums
from voa_store.summaries import object_summary

_AT_ONCE = 100
_SESSIONS = text(
    "SELECT id, scenario, version, last_fit_rmsd_mm, created_at, updated_at, summary, belief, prior "
    "FROM sessions WHERE id = :id"
)
_HISTORY = text(
    "SELECT session, version, kind, at, request, report, last_fit_rmsd_mm, belief "
    "FROM history WHERE session = :id AND version > :after ORDER BY version LIMIT :limit"
)
_SET_ENTRY = text("UPDATE history SET checksum = :checksum WHERE session = :id AND version = :version")
_SET_SESSION = text("UPDATE sessions SET newest = :newest, checksum = :checksum WHERE id = :id")
_SUMMARY = text("INSERT INTO summaries (id, summary) VALUES (:id, :summary)")


def fill_checksums(connection: Connection) -> None:
    """Write the checksum of every version and of every session."""
    for (id_,) in connection.execute(text("SELECT id FROM sessions ORDER BY seq")).all():
        newest = checksums.NOTHING
        for page in _pages(connection, id_):
            filled = []
            for entry in page:
                newest = checksums.of_entry(newest, entry, checksums.of_blob(entry.belief))
                filled.append({"checksum": newest, "id": id_, "version": entry.version})
            connection.execute(_SET_ENTRY, filled)
        row = connection.execute(_SESSIONS, {"id": id_}).one()
        checksum = checksums.of_session(row, newest, checksums.of_blob(row.belief), checksums.of_blob(row.prior))
        connection.execute(_SET_SESSION, {"newest": newest, "checksum": checksum, "id": id_})


def fill_summaries(connection: Connection) -> None:
    """Write the summary of every object and scenario, reading one at a time because each may hold megabytes."""
    for (id_,) in connection.execute(text("SELECT id FROM objects ORDER BY seq")).all():
        mesh = connection.execute(text("SELECT vertices, faces FROM objects WHERE id = :id"), {"id": id_}).one()
        vertices = np.frombuffer(mesh.vertices, dtype="<f8").reshape(-1, 3)
        faces = np.frombuffer(mesh.faces, dtype="<i4").reshape(-1, 3)
        connection.execute(_SUMMARY, {"id": id_, "summary": object_summary(Object(vertices, faces))})
    for (id_,) in connection.execute(text("SELECT id FROM scenarios ORDER BY seq")).all():
        body = connection.execute(text("SELECT body FROM scenarios WHERE id = :id"), {"id": id_}).scalar_one()
        connection.execute(_SUMMARY, {"id": id_, "summary": json.dumps(_of_scenario(json.loads(body)))})


def _pages(connection: Connection, id_: str) -> Iterator[list[Row[Any]]]:
    after = -1
    while page := list(connection.execute(_HISTORY, {"id": id_, "after": after, "limit": _AT_ONCE}).all()):
        yield page
        after = page[-1].version


def _of_scenario(body: dict[str, Any]) -> dict[str, Any]:
    """Summarise a scenario's body as the service did when this migration was written."""
    return {
        "object": body.get("object"),
        "poses": len(body.get("poses", [])),
        "grasps": len(body.get("grasps", [])),
        "sensors": len(body.get("sensors", [])),
        "rule": body.get("update", {}).get("rule"),
    }
