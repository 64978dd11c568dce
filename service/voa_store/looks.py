"""Looks of mapped robots that sessions have accepted: each counts once, although several replicas gather it."""

from sqlalchemy import Connection, bindparam, insert, select

from voa_store.errors import LookRepeated
from voa_store.records import RobotLook
from voa_store.tables import robot_looks as table

_OF_ROBOT = (table.c.session == bindparam("by_session")) & (table.c.robot == bindparam("by_robot"))
_NEWEST = (
    select(table.c.robot, table.c.number, table.c.digest)
    .where(_OF_ROBOT)
    .order_by(table.c.number.desc())
    .limit(bindparam("by_limit"))
)
_NUMBERED = select(table.c.digest).where(_OF_ROBOT, table.c.number == bindparam("by_number"))
_INSERT = insert(table)


def newest_looks(connection: Connection, session: str, robot: str, limit: int) -> list[RobotLook]:
    """Read at most `limit` looks of a robot that a session has accepted, the newest first."""
    rows = connection.execute(_NEWEST, {"by_session": session, "by_robot": robot, "by_limit": limit}).all()
    return [RobotLook(row.robot, row.number, row.digest) for row in rows]


def count_look(connection: Connection, session: str, look: RobotLook) -> None:
    """Store an accepted look, in the transaction that applies it, with the session's row locked.

    Raises:
        LookRepeated: the session has already accepted a look of this robot with this number.
    """
    numbered = {"by_session": session, "by_robot": look.robot, "by_number": look.number}
    if connection.execute(_NUMBERED, numbered).first() is not None:
        raise LookRepeated(look.robot, look.number)
    values = {"session": session, "robot": look.robot, "number": look.number, "digest": look.digest}
    connection.execute(_INSERT, values)
