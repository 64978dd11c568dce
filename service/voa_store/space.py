"""Gives the space of removed rows back to the file system; SQLite keeps it in its file otherwise."""

import time
from collections.abc import Callable
from typing import Any

from sqlalchemy import Connection, Engine

from voa_store.engines import statement, transaction

_PAGES = 256
"""Pages that are given back in one transaction, which other writers wait for: 1 MB, some milliseconds."""
_RESERVE = 1_024
"""Free pages that stay in the file, so that it does not shrink and grow in turns."""
_INCREMENTAL = 2


def give_back(writer: Engine, pause: Callable[[float], object] = time.sleep) -> int:
    """Give free pages of an SQLite file back a few at a time; returns the number of pages.

    Nothing is done for PostgreSQL, which does this by itself, and for files from before the store used incremental
    vacuuming: a backup that is restored is such a file no more.

    Args:
        writer: engine for transactions that write.
        pause: sleeps for so many seconds between two transactions; returns true to end early.
    """
    given = 0
    while writer.dialect.name == "sqlite":
        began = time.monotonic()
        with transaction(writer) as connection:
            free = _free(connection)
            if free <= _RESERVE:
                break
            driver: Any = connection.connection.dbapi_connection  # each step frees a page, and SQLAlchemy makes one
            driver.execute(f"PRAGMA incremental_vacuum({min(_PAGES, free - _RESERVE)})").fetchall()
            given += free - _free(connection)
        if pause(time.monotonic() - began):
            break
    if given:
        with statement(writer) as connection:  # the file shrinks when the write-ahead log is written back to it
            checkpoint: Any = connection.connection.dbapi_connection
            checkpoint.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()
    return given


def _free(connection: Connection) -> int:
    """Number of free pages that can be given back."""
    mode = connection.exec_driver_sql("PRAGMA auto_vacuum").scalar_one()
    return int(connection.exec_driver_sql("PRAGMA freelist_count").scalar_one()) if mode == _INCREMENTAL else 0
