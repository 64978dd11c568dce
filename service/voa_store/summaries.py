"""Reads lists of objects, scenarios and sessions without their meshes, bodies and beliefs."""

import json
from collections.abc import Collection
from datetime import datetime
from typing import Any

from sqlalchemy import BigInteger, Connection, Row, Select, Table, bindparam, select

from voa_core.objects import Object
from voa_store.records import Listed, ListedObject, ListedScenario, ListedSession
from voa_store.tables import GONE, objects, scenarios, sessions, summaries

_START = -1


def _page(query: Select[Any], table: Table) -> Select[Any]:
    after = table.c.seq > bindparam("by_seq", type_=BigInteger)
    return query.where(after).order_by(table.c.seq).limit(bindparam("by_limit"))


_OBJECTS = _page(
    select(objects.c.seq, objects.c.id, objects.c.name, objects.c.created_at, objects.c.up, summaries.c.summary).join(
        summaries, summaries.c.id == objects.c.id
    ),
    objects,
)
_SCENARIOS = _page(
    select(scenarios.c.seq, scenarios.c.id, scenarios.c.name, scenarios.c.created_at, summaries.c.summary).join(
        summaries, summaries.c.id == scenarios.c.id
    ),
    scenarios,
)
_SESSIONS = _page(
    select(
        *(
            sessions.c[name]
            for name in (
                "seq",
                "id",
                "scenario",
                "version",
                "last_fit_rmsd_mm",
                "created_at",
                "updated_at",
                "summary",
            )
        )
    ).where(sessions.c.version > GONE),
    sessions,
)
_SOME_SESSIONS = _SESSIONS.where(sessions.c.id.in_(bindparam("by_ids", expanding=True)))


def object_summary(mesh: Object) -> str:
    """Write the facts that lists show about a mesh, as JSON."""
    extents = [float(extent) for extent in mesh.extents]
    return json.dumps({"extents": extents, "faces": len(mesh.faces), "watertight": mesh.watertight})


def list_objects(connection: Connection, limit: int, after: str | None) -> Listed[ListedObject]:
    """List at most `limit` meshes after a cursor, oldest first."""
    rows, more = _rows(connection, _OBJECTS, limit, after)
    return Listed([_object(row) for row in rows], more)


def list_scenarios(connection: Connection, limit: int, after: str | None) -> Listed[ListedScenario]:
    """List at most `limit` scenarios after a cursor, oldest first."""
    rows, more = _rows(connection, _SCENARIOS, limit, after)
    return Listed([ListedScenario(row.id, row.name, row.summary, _time(row.created_at)) for row in rows], more)


def list_sessions(
    connection: Connection, limit: int, after: str | None, only: Collection[str] | None = None
) -> Listed[ListedSession]:
    """List at most `limit` sessions after a cursor, oldest first, without deleted ones.

    Args:
        connection: of the transaction.
        limit: most sessions to list.
        after: cursor; None: from the start.
        only: ids of the only sessions to list; None: all.
    """
    if only is None:
        rows, more = _rows(connection, _SESSIONS, limit, after)
    else:
        rows, more = _rows(connection, _SOME_SESSIONS, limit, after, by_ids=sorted(only))
    return Listed([_session(row) for row in rows], more)


def _rows(
    connection: Connection, query: Select[Any], limit: int, after: str | None, **more: Any
) -> tuple[list[Row[Any]], str | None]:
    """Read a page of rows; returns it with the cursor of the next page, None: this is the last one."""
    start = _START if after is None else int(after)
    rows = list(connection.execute(query, {"by_seq": start, "by_limit": limit + 1, **more}).all())
    return rows[:limit], str(rows[limit - 1].seq) if len(rows) > limit else None


def _object(row: Row[Any]) -> ListedObject:
    summary = json.loads(row.summary)
    x, y, z = summary["extents"]
    return ListedObject(
        row.id, row.name, (x, y, z), summary["faces"], summary["watertight"], row.up, _time(row.created_at)
    )


def _session(row: Row[Any]) -> ListedSession:
    return ListedSession(
        row.id,
        row.scenario,
        row.version,
        row.last_fit_rmsd_mm,
        row.summary,
        _time(row.created_at),
        _time(row.updated_at),
    )


def _time(stored: str) -> datetime:
    return datetime.fromisoformat(stored)
