"""Hears from PostgreSQL which sessions other processes moved (LISTEN), so that nobody has to wait for a look."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import structlog

CHANNEL = "voa_sessions"

_LOOK_SECONDS = 0.5  # how late the end is noticed
_AGAIN_SECONDS = 1.0  # after the database went
_END_SECONDS = 1.0  # a host that is silent is not waited for


class Listener:
    """A thread with a connection of its own; it comes back when the database does."""

    def __init__(self, parameters: Mapping[str, Any], moved: Callable[[str], None]) -> None:
        self._parameters = dict(parameters)
        self._moved = moved
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voa-listener", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join(_END_SECONDS)

    def _run(self) -> None:
        import psycopg  # noqa: PLC0415 - the extra `postgres`; without it there is no such database

        while not self._ended.is_set():
            try:
                with psycopg.connect(**self._parameters, autocommit=True) as connection:
                    connection.execute(f"LISTEN {CHANNEL}")
                    while not self._ended.is_set():
                        for notice in connection.notifies(timeout=_LOOK_SECONDS):
                            self._moved(notice.payload)
            except psycopg.Error as error:
                structlog.get_logger().warning("not listening", error=f"{type(error).__name__}: {error}")
                self._ended.wait(_AGAIN_SECONDS)
