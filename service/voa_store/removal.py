"""Removes the rows of deleted sessions a few at a time, so that no writer waits while a long history is removed.

The transaction of a deletion only marks the session (`tables.GONE`), and no query returns it from then on. Rows that a
killed process has left are removed by the next process that starts.
"""

import threading
import time
from typing import Any

import structlog
from sqlalchemy import Connection, bindparam, delete, func, select

from voa_store.engines import Engines, statement, transaction
from voa_store.errors import StoreError
from voa_store.responses import remove_responses
from voa_store.space import give_back
from voa_store.tables import GONE, history, robot_looks, sessions

_GOAL_SECONDS = 0.02  # longest time that one transaction should keep others from writing
_FIRST_ROWS, _MOST_ROWS = 32, 1_000
_RETRY_SECONDS = 1.0  # pause after the database failed
_END_SECONDS = 5.0

_GONE = select(sessions.c.id).where(sessions.c.version == GONE).order_by(sessions.c.seq).limit(1)
_OF_ONE = _GONE.with_for_update(skip_locked=True)  # PostgreSQL: skips a session that another replica is removing
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
    """Background thread that runs while there are rows to remove.

    Args:
        engines: of the database.
    """

    def __init__(self, engines: Engines) -> None:
        self._engines = engines
        self._closed = threading.Event()
        self._lock = threading.Lock()
        self._again = False
        self._thread: threading.Thread | None = None

    def wake(self) -> None:
        """Start removing the rows of marked sessions in the background."""
        with self._lock:
            self._again = True
            if self._thread is None and not self._closed.is_set():
                self._thread = threading.Thread(target=self._run, name="voa-remover", daemon=True)
                self._thread.start()

    def wake_if_needed(self) -> None:
        """Start removing if an earlier process has left rows of marked sessions."""
        with statement(self._engines.single) as connection:
            if connection.execute(_GONE).first() is not None:
                self.wake()

    def close(self) -> None:
        """Stop the thread; the remaining rows are removed at the next start."""
        with self._lock:
            self._closed.set()
            thread = self._thread
        if thread is not None:
            thread.join(_END_SECONDS)

    def _run(self) -> None:
        while self._more():
            try:
                self._remove_all()
            except StoreError as error:
                structlog.get_logger().warning("rows of deleted sessions cannot be removed yet", error=str(error))
                self._closed.wait(_RETRY_SECONDS)
                with self._lock:
                    self._again = True

    def _more(self) -> bool:
        """Return True if `wake` was called since the last round; otherwise the thread counts as ended."""
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
            self._closed.wait(time.monotonic() - began)  # leaves other writers as much time as this took
        give_back(self._engines.writer, self._closed.wait)


def remove_some(connection: Connection, rows: int) -> bool:
    """Remove at most `rows` rows of a deleted session; False: there is no deleted session."""
    id_ = connection.execute(_OF_ONE).scalar_one_or_none()
    if id_ is None:
        return False
    remove_rows(connection, id_, rows)
    return True


def remove_rows(connection: Connection, id_: str, rows: int) -> None:
    """Remove at most `rows` rows of a session, and the session's own row once there are no others."""
    named: dict[str, Any] = {"by_id": id_}
    lowest = connection.execute(_LOWEST, named).scalar_one()
    if lowest is not None:
        connection.execute(_DELETE, named | {"by_version": lowest + rows})
        return
    look = connection.execute(_FIRST_LOOK, named).first()
    if look is not None:
        connection.execute(_DELETE_LOOKS, named | {"by_robot": look.robot, "by_number": look.number + rows})
        return
    if not remove_responses(connection, id_, rows):
        connection.execute(_DELETE_SESSION, named)
