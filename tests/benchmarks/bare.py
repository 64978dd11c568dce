"""Makes the bare transactions that durable updates are compared with: the raw driver, and the rows of a scan update.

A transaction reads a session's row under its lock, writes the columns that a version changes, appends a row to the
history, and commits; the values are those of a real update. Nothing is computed, verified or converted.

SQLite lets one connection write at a time, and the others poll, with pauses that leave the disk idle most of the time:
its writers take turns by a lock of this process, which makes them three times as fast.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from threading import Lock
from typing import Any

import psycopg

from voa_store.drivers import sqlite_driver

_BUSY_SECONDS = 60.0
_CHANGING = ("belief", "last_fit_rmsd_mm", "updated_at", "summary", "newest", "checksum", "looks", "under_way")
_HISTORY = ("kind", "at", "request", "report", "belief", "last_fit_rmsd_mm", "checksum", "looks")

Connect = Callable[[], Any]


@dataclass(frozen=True)
class Rows:
    """Values that a scan update has written.

    Attributes:
        session: of the columns of its session's row that change, but for the version.
        entry: of the columns of its row of the history, but for session and version.
    """

    session: tuple[Any, ...]
    entry: tuple[Any, ...]


@dataclass(frozen=True)
class Dialect:
    """Way in which a driver states a transaction.

    Attributes:
        connect: opens a connection with no transaction, which commits durably.
        begin: begins a transaction that writes.
        lock: ends the query that reads a row, so that it is locked.
        mark: stands for a value in a statement.
        turn: held for each transaction.
    """

    connect: Connect
    begin: str
    lock: str
    mark: str
    turn: AbstractContextManager[object]

    def read(self, session: str) -> Rows:
        """Read the newest rows of a session that a scan has updated."""
        connection = self.connect()
        try:
            texts = (
                f"SELECT {', '.join(_CHANGING)} FROM sessions WHERE id = {self.mark}",  # noqa: S608 - names from this code alone
                f"SELECT {', '.join(_HISTORY)} FROM history WHERE session = {self.mark} ORDER BY version DESC LIMIT 1",  # noqa: S608 - names from this code alone
            )
            own, entry = (connection.execute(text, (session,)).fetchone() for text in texts)
            return Rows(tuple(own), tuple(entry))
        finally:
            connection.close()

    def writer(self, session: str, rows: Rows) -> tuple[Callable[[], None], Callable[[], None]]:
        """Open a connection; returns a function that makes one transaction on a session, and one that disconnects."""
        execute, mark = (connection := self.connect()).execute, self.mark
        read = f"SELECT * FROM sessions WHERE id = {mark}{self.lock}"  # noqa: S608 - names from this code alone
        changes = ", ".join(f"{name} = {mark}" for name in ("version", *_CHANGING))
        update = f"UPDATE sessions SET {changes} WHERE id = {mark}"  # noqa: S608 - names from this code alone
        columns = ("session", "version", *_HISTORY)
        append = f"INSERT INTO history ({', '.join(columns)}) VALUES ({', '.join(len(columns) * [mark])})"  # noqa: S608 - names from this code alone
        at = [column[0] for column in execute("SELECT * FROM sessions LIMIT 0").description].index("version")

        def write() -> None:
            with self.turn:
                execute(self.begin)
                version = execute(read, (session,)).fetchone()[at] + 1
                execute(update, (version, *rows.session, session))
                execute(append, (session, version, *rows.entry))
                execute("COMMIT")

        return write, connection.close


def sqlite(file: str) -> Dialect:
    """Return the dialect of an SQLite file in WAL mode, which commits as durably as the store does."""

    def connect() -> Any:
        connection = sqlite_driver().connect(file, timeout=_BUSY_SECONDS, isolation_level=None, check_same_thread=False)
        for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON"):
            connection.execute(f"PRAGMA {pragma}")
        return connection

    return Dialect(connect, "BEGIN IMMEDIATE", "", "?", Lock())


def postgres(url: str) -> Dialect:
    """Return the dialect of a PostgreSQL database, whose server commits durably."""
    return Dialect(lambda: psycopg.connect(url, autocommit=True), "BEGIN", " FOR UPDATE", "%s", nullcontext())
