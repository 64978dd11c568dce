"""Whose session a mapped robot's scans are for: one row for each robot that ever had one.

A row holds while its session exists, or while it says that the scans are for nobody. A robot without a row takes the
newest session on its scenario; one whose session was deleted takes the newest that was opened after it. Which one
that is becomes a row, and is the same for all processes from then on, when `settle` is called.

Every function here works on the caller's connection, within the caller's transaction.
"""

from typing import Any, NamedTuple

from sqlalchemy import BigInteger, Connection, Row, Select, bindparam, func, select, update
from sqlalchemy.dialects import postgresql, sqlite

from voa_store.tables import GONE, claims, sessions

_BEFORE_ALL = -1

_CLAIM = select(claims).where(claims.c.robot == bindparam("by_robot"))
_LOCK_CLAIM = _CLAIM.with_for_update()
_SESSION: Select[Any] = select(sessions.c.id, sessions.c.scenario, sessions.c.seq).where(
    sessions.c.id == bindparam("by_id"), sessions.c.version > GONE
)
_NEWEST_AFTER: Select[Any] = (
    select(sessions.c.id, sessions.c.scenario, sessions.c.seq)
    .where(
        sessions.c.scenario == bindparam("by_scenario"),
        sessions.c.seq > bindparam("by_seq", type_=BigInteger),
        sessions.c.version > GONE,
    )
    .order_by(sessions.c.seq.desc())
    .limit(1)
)
_MOVE = update(claims).where(claims.c.robot == bindparam("by_robot"))
_NEXT_ORDER = select(
    func.max(
        func.coalesce(select(func.max(sessions.c.seq)).scalar_subquery(), 0),
        func.coalesce(select(func.max(claims.c.after)).scalar_subquery(), 0),
    )
    + 1
)


class Found(NamedTuple):
    """The session that a robot's next look is for.

    Attributes:
        session: its row, with `id`, `scenario` and `seq`; None: there is none.
        settled: whether the robot's own row says so; `settle` then changes nothing.
    """

    session: Row[Any] | None
    settled: bool

    @property
    def id(self) -> str | None:
        """The session's id."""
        return None if self.session is None else str(self.session.id)


def find(connection: Connection, robot: str, scenario: str) -> Found:
    """Find the session that a look of a robot, mapped to a scenario, would be for now."""
    return _found(connection, connection.execute(_CLAIM, {"by_robot": robot}).one_or_none(), scenario)


def settle(connection: Connection, robot: str, scenario: str) -> str | None:
    """Make the session that `find` finds the robot's own; of processes that do so at once the first one decides."""
    row = connection.execute(_LOCK_CLAIM, {"by_robot": robot}).one_or_none()
    found = _found(connection, row, scenario)
    if found.session is None or found.settled:
        return found.id
    if row is not None:
        connection.execute(_MOVE, {"by_robot": robot, **_columns(found.session)})
        return found.id
    connection.execute(_insert(connection).on_conflict_do_nothing(), {"robot": robot, **_columns(found.session)})
    return find(connection, robot, scenario).id  # another process may have been first


def put(connection: Connection, robot: str, session: str | None) -> bool:
    """Say whose session a robot's scans are for, None: nobody's; returns False where there is no such session."""
    claimed = None if session is None else connection.execute(_SESSION, {"by_id": session}).one_or_none()
    if claimed is None and session is not None:
        return False
    inserted = _insert(connection)
    changed = {name: inserted.excluded[name] for name in ("session", "scenario", "after")}
    statement = inserted.on_conflict_do_update(index_elements=[claims.c.robot], set_=changed)
    connection.execute(statement, {"robot": robot, **_columns(claimed)})
    return True


def next_order(connection: Connection) -> dict[str, int]:
    """Give the `seq` of a new session, where the database itself would give one a second time.

    SQLite gives the number of a deleted session again if it was the newest; a claim on that one must still tell what
    was opened after it. PostgreSQL never does.
    """
    return {"seq": connection.execute(_NEXT_ORDER).scalar_one()} if connection.dialect.name == "sqlite" else {}


def _found(connection: Connection, row: Row[Any] | None, scenario: str) -> Found:
    """Apply the rules to a robot's row; None: it has none."""
    after = _BEFORE_ALL
    if row is not None and row.session is None:
        return Found(None, settled=True)
    if row is not None and row.scenario == scenario:  # else its mapping names another scenario since
        session = connection.execute(_SESSION, {"by_id": row.session}).one_or_none()
        if session is not None:
            return Found(session, settled=True)
        after = row.after
    newest = connection.execute(_NEWEST_AFTER, {"by_scenario": scenario, "by_seq": after}).one_or_none()
    return Found(newest, settled=False)


def _columns(session: Row[Any] | None) -> dict[str, Any]:
    """The columns of a claim beside the robot; None: the robot's scans are for nobody."""
    if session is None:
        return {"session": None, "scenario": None, "after": _BEFORE_ALL}
    return {"session": session.id, "scenario": session.scenario, "after": session.seq}


def _insert(connection: Connection) -> "sqlite.Insert | postgresql.Insert":
    """An insertion that can say what to do about a row that is there; each database has its own."""
    return sqlite.insert(claims) if connection.dialect.name == "sqlite" else postgresql.insert(claims)
