"""Receives from PostgreSQL (LISTEN) which sessions other processes changed, so that followers need not poll."""

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import structlog
from sqlalchemy import Connection, text

CHANNEL = "voa_sessions"

_POLL_SECONDS = 0.5  # delay until the thread sees that it should end
_RETRY_SECONDS = 1.0  # pause after a connection failed
_END_SECONDS = 1.0  # longest wait for the thread, which may hang on a host that does not answer
_NOTIFY = text("SELECT pg_notify(:channel, :session)")


def notify(connection: Connection, sessions: Sequence[str]) -> None:
    """Notify other processes of changed sessions once this transaction is committed; SQLite cannot."""
    if sessions and connection.dialect.name == "postgresql":
        connection.execute(_NOTIFY, [{"channel": CHANNEL, "session": session} for session in sessions])


class Listener:
    """Thread with a connection of its own that receives notifications; it reconnects after an outage.

    Args:
        parameters: of the PostgreSQL connection, as libpq takes them.
        moved: called in this thread with the id of each session that another process changed.
    """

    def __init__(self, parameters: Mapping[str, Any], moved: Callable[[str], None]) -> None:
        self._parameters = dict(parameters)
        self._moved = moved
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voa-listener", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the thread."""
        self._ended.set()
        self._thread.join(_END_SECONDS)

    def _run(self) -> None:
        import psycopg  # noqa: PLC0415 - the extra `postgres`; without it there is no such database

        while not self._ended.is_set():
            try:
                with psycopg.connect(**self._parameters, autocommit=True) as connection:
                    connection.execute(f"LISTEN {CHANNEL}")
                    while not self._ended.is_set():
                        for notice in connection.notifies(timeout=_POLL_SECONDS):
                            self._moved(notice.payload)
            except psycopg.Error as error:
                structlog.get_logger().warning(
                    "cannot receive changes of other processes, trying again", error=f"{type(error).__name__}: {error}"
                )
                self._ended.wait(_RETRY_SECONDS)
