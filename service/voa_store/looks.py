"""Looks of mapped robots that sessions have accepted: each counts once, although several replicas gather it."""

from collections.abc import Collection, Iterable

from sqlalchemy import Connection, bindparam, select, tuple_

from voa_store.errors import LookRepeated
from voa_store.records import RobotLook
from voa_store.rows import Columns
from voa_store.tables import robot_looks as table

_OF_ROBOT = (table.c.session == bindparam("by_session")) & (table.c.robot == bindparam("by_robot"))
_NEWEST = (
    select(table.c.robot, table.c.number, table.c.digest)
    .where(_OF_ROBOT)
    .order_by(table.c.number.desc())
    .limit(bindparam("by_limit"))
)
_NAMES = (table.c.session, table.c.robot, table.c.number)
_COUNTED = select(*_NAMES).where(tuple_(*_NAMES).in_(bindparam("by_names", expanding=True)))


def newest_looks(connection: Connection, session: str, robot: str, limit: int) -> list[RobotLook]:
    """Read at most `limit` looks of a robot that a session has accepted, the newest first."""
    rows = connection.execute(_NEWEST, {"by_session": session, "by_robot": robot, "by_limit": limit}).all()
    return [RobotLook(row.robot, row.number, row.digest) for row in rows]


def counted_looks(connection: Connection, looks: Iterable[tuple[str, RobotLook]]) -> frozenset[tuple[str, str, int]]:
    """Find the looks whose numbers are taken, in the transaction that applies them, with the sessions' rows locked.

    Args:
        connection: of the transaction.
        looks: each with the id of its session.

    Returns:
        Session, robot and number of each look that the session has already accepted one of that number for.
    """
    named = [(session, look.robot, look.number) for session, look in looks]
    if not named:
        return frozenset()
    return frozenset((row.session, row.robot, row.number) for row in connection.execute(_COUNTED, {"by_names": named}))


def look_row(session: str, look: RobotLook, counted: Collection[tuple[str, str, int]]) -> Columns:
    """Return the row of an accepted look.

    Args:
        session: id of the session.
        look: that it accepts.
        counted: result of `counted_looks`.

    Raises:
        LookRepeated: the session has already accepted a look of this robot with this number.
    """
    if (session, look.robot, look.number) in counted:
        raise LookRepeated(look.robot, look.number)
    return {"session": session, "robot": look.robot, "number": look.number, "digest": look.digest}
