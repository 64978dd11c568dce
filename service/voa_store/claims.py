"""Claims of mapped robots: a row for each robot says which session its scans belong to.

A row is valid while its session exists, or while it says that the robot was released from every session. A robot
without a row belongs to the newest session on its scenario; one whose session was deleted belongs to the newest session
that was opened after that one. `settle` writes this choice into a row, which all processes follow from then on.

Every function works on the caller's connection, within the caller's transaction.
"""

from typing import Any, NamedTuple

from sqlalchemy import BigInteger, Connection, Row, Select, bindparam, func, select, update
from sqlalchemy.dialects import postgresql, sqlite

from voa_store.records import RobotClaim
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


class Assignment(NamedTuple):
    """The session that a robot's next look belongs to.

    Attributes:
        session: the session's row, with `id`, `scenario` and `seq`; None: there is none.
        settled: True if the robot's own row states it; `settle` then changes nothing.
    """

    session: Row[Any] | None
    settled: bool

    @property
    def id(self) -> str | None:
        """Id of the session; None: there is none."""
        return None if self.session is None else str(self.session.id)


def find(connection: Connection, robot: str, scenario: str) -> Assignment:
    """Find the session that the next look of a robot, mapped to a scenario, belongs to."""
    return _assignment(connection, connection.execute(_CLAIM, {"by_robot": robot}).one_or_none(), scenario)


def claimed(connection: Connection, robot: str) -> RobotClaim | None:
    """Return the claim on a robot, on whichever scenario; None: there is none, or its session was deleted."""
    row = connection.execute(_CLAIM, {"by_robot": robot}).one_or_none()
    if row is None:
        return None
    if row.session is None:
        return RobotClaim(None)
    session = connection.execute(_SESSION, {"by_id": row.session}).one_or_none()
    return None if session is None else RobotClaim(str(session.id))


def settle(connection: Connection, robot: str, scenario: str) -> str | None:
    """Claim a robot for the session that `find` returns; if several processes do so at once, the first one decides."""
    row = connection.execute(_LOCK_CLAIM, {"by_robot": robot}).one_or_none()
    assignment = _assignment(connection, row, scenario)
    if assignment.session is None or assignment.settled:
        return assignment.id
    if row is not None:
        connection.execute(_MOVE, {"by_robot": robot, **_columns(assignment.session)})
        return assignment.id
    connection.execute(_insert(connection).on_conflict_do_nothing(), {"robot": robot, **_columns(assignment.session)})
    return find(connection, robot, scenario).id  # another process may have been first


def put(connection: Connection, robot: str, session: str | None) -> bool:
    """Claim a robot for a session, or release it from every session (None); False: there is no such session."""
    claimed = None if session is None else connection.execute(_SESSION, {"by_id": session}).one_or_none()
    if claimed is None and session is not None:
        return False
    inserted = _insert(connection)
    changed = {name: inserted.excluded[name] for name in ("session", "scenario", "after")}
    statement = inserted.on_conflict_do_update(index_elements=[claims.c.robot], set_=changed)
    connection.execute(statement, {"robot": robot, **_columns(claimed)})
    return True


def next_order(connection: Connection) -> dict[str, int]:
    """Return the `seq` column of a new session for SQLite, and no column for PostgreSQL.

    SQLite would reuse the number of a deleted session that was the newest, but claims compare sessions by `seq` even
    with deleted ones. PostgreSQL never reuses a number.
    """
    return {"seq": connection.execute(_NEXT_ORDER).scalar_one()} if connection.dialect.name == "sqlite" else {}


def _assignment(connection: Connection, row: Row[Any] | None, scenario: str) -> Assignment:
    """Apply the rules to a robot's row; None: it has no row."""
    after = _BEFORE_ALL
    if row is not None and row.session is None:
        return Assignment(None, settled=True)
    if row is not None and row.scenario == scenario:  # otherwise the mapping names another scenario by now
        session = connection.execute(_SESSION, {"by_id": row.session}).one_or_none()
        if session is not None:
            return Assignment(session, settled=True)
        after = row.after
    newest = connection.execute(_NEWEST_AFTER, {"by_scenario": scenario, "by_seq": after}).one_or_none()
    return Assignment(newest, settled=False)


def _columns(session: Row[Any] | None) -> dict[str, Any]:
    """Return the columns of a claim except the robot; None: the robot is released from every session."""
    if session is None:
        return {"session": None, "scenario": None, "after": _BEFORE_ALL}
    return {"session": session.id, "scenario": session.scenario, "after": session.seq}


def _insert(connection: Connection) -> "sqlite.Insert | postgresql.Insert":
    """Build an insertion with a conflict clause, which each database spells in its own dialect."""
    return sqlite.insert(claims) if connection.dialect.name == "sqlite" else postgresql.insert(claims)
