"""Removes the rows of deleted sessions, a few at a time, so that nobody waits for a long history to go.

A deleted session is marked (`tables.GONE`) in the transaction that answers the deletion; from then on nobody sees it.
What a killed process left is removed by the next one that starts.
"""

import threading
import time
from typing import Any

import structlog
from sqlalchemy import Connection, bindparam, delete, func, select

from voa_service.failures import Failure
from voa_store.engines import Engines, statement, transaction
from voa_store.tables import GONE, history, robot_looks, sessions

_GOAL_SECONDS = 0.02  # that one transaction may keep others from writing
_FIRST_ROWS, _MOST_ROWS = 32, 1_000
_AGAIN_SECONDS = 1.0  # after the database failed
_END_SECONDS = 5.0

_GONE = select(sessions.c.id).where(sessions.c.version == GONE).order_by(sessions.c.seq).limit(1)
_OF_ONE = _GONE.with_for_update(skip_locked=True)  # another replica removes that one: PostgreSQL
_LOWEST = select(func.min(history.c.version)).where(history.c.session == bindparam("by_id"))
_DELETE = delete(history).where(history.c.session == bindparam("by_id"), history.c.version < bindparam("by_version"))
_LOOKS = robot_looks.c.session == bindparam("by_id")
_FIRST_LOOK = (
    select(robot_looks.c.robot, robot_looks.c.number)
    .where(_LOOKS)
    .order_by(robot_looks.c.robot, robot_looks.c.number)
    .limit(1)
)
_DELETE_LOOKS = delete(robot_looks).where(
    _LOOKS, robot_looks.c.robot == bindparam("by_robot"), robot_looks.c.number < bindparam("by_number")
)
_DELETE_SESSION = delete(sessions).where(sessions.c.id == bindparam("by_id"))


class Remover:
    """A thread that runs while there is something to remove."""

    def __init__(self, engines: Engines) -> None:
        self._engines = engines
        self._closed = threading.Event()
        self._lock = threading.Lock()
        self._again = False
        self._thread: threading.Thread | None = None

    def wake(self) -> None:
        """Remove what is marked, from now on and in the background."""
        with self._lock:
            self._again = True
            if self._thread is None and not self._closed.is_set():
                self._thread = threading.Thread(target=self._run, name="voa-remover", daemon=True)
                self._thread.start()

    def wake_if_needed(self) -> None:
        """Remove what an earlier process marked and did not remove."""
        with statement(self._engines.single) as connection:
            if connection.execute(_GONE).first() is not None:
                self.wake()

    def close(self) -> None:
        """End the thread; what is left is removed at the next start."""
        with self._lock:
            self._closed.set()
            thread = self._thread
        if thread is not None:
            thread.join(_END_SECONDS)

    def _run(self) -> None:
        while self._more():
            try:
                self._remove_all()
            except Failure as failure:
                structlog.get_logger().warning("deleted sessions wait to be removed", error=failure.detail)
                self._closed.wait(_AGAIN_SECONDS)
                with self._lock:
                    self._again = True

    def _more(self) -> bool:
        """Whether anybody woke this thread since it looked last; if not, it has ended."""
        with self._lock:
            if not self._again or self._closed.is_set():
                self._thread = None
                return False
            self._again = False
            return True

    def _remove_all(self) -> None:
        rows, removed = _FIRST_ROWS, True
        while removed and not self._closed.is_set():
            began = time.monotonic()
            with transaction(self._engines.writer) as connection:
                entered = time.monotonic()
                removed = remove_some(connection, rows)
            took = time.monotonic() - entered
            rows = max(1, min(_MOST_ROWS, rows * 2 if took < _GOAL_SECONDS / 2 else rows))
            if took > _GOAL_SECONDS:
                rows = max(1, int(rows * _GOAL_SECONDS / took))
            self._closed.wait(time.monotonic() - began)  # others write for as long


def remove_some(connection: Connection, rows: int) -> bool:
    """Remove at most `rows` rows of a deleted session; returns whether there was one."""
    id_ = connection.execute(_OF_ONE).scalar_one_or_none()
    if id_ is None:
        return False
    remove_rows(connection, id_, rows)
    return True


def remove_rows(connection: Connection, id_: str, rows: int) -> None:
    """Remove at most `rows` rows of one session, and the session itself after the last of them."""
    named: dict[str, Any] = {"by_id": id_}
    lowest = connection.execute(_LOWEST, named).scalar_one()
    if lowest is not None:
        connection.execute(_DELETE, named | {"by_version": lowest + rows})
        return
    look = connection.execute(_FIRST_LOOK, named).first()
    if look is not None:
        connection.execute(_DELETE_LOOKS, named | {"by_robot": look.robot, "by_number": look.number + rows})
        return
    connection.execute(_DELETE_SESSION, named)
