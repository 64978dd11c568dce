"""Implements the service's port `Store` on a relational database.

A write is one transaction: lock the session (SQLite: BEGIN IMMEDIATE, one writer; PostgreSQL: its row), look up the
idempotency key, verify the checksum, check the version, apply, append to the history, store the response. Writers on
one session wait for each other and never retry; those on different sessions share a transaction where they come at the
same time (`changing`). A response is sent only after its transaction is committed and on the disk.
"""

import math
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from sqlalchemy import Row, bindparam, delete, insert, literal_column, select, update
from sqlalchemy.exc import DBAPIError, IntegrityError

from voa_store import checksums, claims
from voa_store.changing import SessionWriter, check_version
from voa_store.contents import Contents, named_row
from voa_store.engines import connect, first, statement, transaction
from voa_store.errors import ContentMissing, StoreError
from voa_store.histories import read_history
from voa_store.keys import KeyRecords
from voa_store.listening import Listener, notify
from voa_store.migrate import migrate
from voa_store.probing import Probe
from voa_store.records import (
    HistoryEntry,
    IdempotencyKey,
    Listed,
    ListedSession,
    SessionChange,
    SessionMark,
    SessionState,
    Step,
    StoredResponse,
    Write,
)
from voa_store.removal import Remover
from voa_store.responses import (
    date_some,
    has_more_responses,
    keep_response,
    remove_old,
    remove_responses,
    stored_response,
)
from voa_store.revisions import can_serve
from voa_store.robots import RobotRecords
from voa_store.rows import blob, session_of, written
from voa_store.space import give_back
from voa_store.summaries import list_sessions
from voa_store.tables import GONE, history, sessions

PATIENCE_SECONDS = 4.0
_AT_ONCE = 64  # versions, and stored responses, of a session that are removed in the transaction that deletes it
_ROWS = 256  # stored responses that are dated or removed in one transaction
# Built once, so that SQLAlchemy finds their compiled form in its cache by identity.
_INSERT = {table: insert(table) for table in (sessions, history)}
_BY_ID = select(sessions).where(sessions.c.id == bindparam("by_id"), sessions.c.version > GONE)
_NEWEST = select(sessions).where(sessions.c.version > GONE).order_by(sessions.c.seq.desc()).limit(1)
_LOCK = _BY_ID.with_for_update()
_UPDATE = update(sessions).where(sessions.c.id == bindparam("by_id"))
_DELETE = delete(sessions).where(sessions.c.id == bindparam("by_id"))
_MARK = select(sessions.c.version, sessions.c.updated_at, sessions.c.under_way).where(
    sessions.c.id == bindparam("by_id"), sessions.c.version > literal_column(str(GONE))
)


class SqlStore(Contents, RobotRecords, KeyRecords):
    """Store on a database URL, `sqlite:///voa.db` or `postgresql://user@host/voa`.

    Args:
        url: of the database.
        patience_s: seconds for which PostgreSQL may be silent before a call fails.
        seconds: clock of stored responses, seconds since 1970.

    Raises:
        StoreError: the database cannot be used; `starting.open_store` explains errors of drivers too.
    """

    def __init__(
        self, url: str, patience_s: float = PATIENCE_SECONDS, seconds: Callable[[], float] = time.time
    ) -> None:
        self._seconds = seconds
        self._engines = connect(url, patience_s)
        Contents.__init__(self, self._engines)
        self._readers = self._engines.readers
        self._mark = _MARK.compile(dialect=self._single.dialect)
        self._session_writer = SessionWriter(self._writer, self._now)
        self._listener: Listener | None = None
        self._probe = Probe(self._engines)
        self._remover = Remover(self._engines)
        try:
            migrate(self._engines)
            self._remover.wake_if_needed()
        except BaseException:
            self._engines.dispose()
            raise

    @property
    def software(self) -> str:
        """Name of the database's software with its version ("SQLite 3.53.4")."""
        return self._engines.software

    @property
    def troubles(self) -> int:
        """Number of calls that the database has failed so far."""
        return self._engines.calls.failed

    def ping(self) -> None:
        """Return if this version can work with the tables, and a row can be written.

        Raises:
            StoreError: the database cannot be read or written.
            RuntimeError: the tables are those of a version of the service with which this one cannot share them.
        """
        with statement(self._single) as connection:
            if not can_serve(connection):
                raise RuntimeError("another version of the service has changed the tables: restart or update this one")
        self._probe.write()

    def warm(self) -> None:
        """Connect, and compile the queries of a scan update, which the first one would have to wait for.

        A database that fails is left for `ping` to report.
        """
        with suppress(StoreError, DBAPIError):
            self._session_writer.warm()
            self.get_session("")
            self.get_scenario("")
            self.session_mark("")

    def measure(self, observe: Callable[[float], None]) -> None:
        """Call `observe` with the wall time of each transaction and each single statement, seconds."""
        self._engines.calls.observe = observe

    def close(self) -> None:
        """Close all connections and end all threads."""
        if self._listener is not None:
            self._listener.close()
        self._remover.close()
        self._engines.dispose()

    def listen(self, moved: Callable[[str], None]) -> None:
        """Call `moved`, from any thread, with the id of each session that another process changes (PostgreSQL)."""
        if self._writer.dialect.name == "postgresql":
            self._listener = Listener(self._engines.parameters, moved)

    def get_response(self, key: IdempotencyKey) -> StoredResponse | None:
        """Read the response stored under an idempotency key; None: the key has not been used.

        Raises:
            KeyReused: the key was used for another request.
        """
        with statement(self._single) as connection:
            return stored_response(connection, key)

    def create_session(
        self, state: SessionState, write: Write, response: StoredResponse, robots: Sequence[str] = ()
    ) -> StoredResponse:
        """Store a new session with its prior as version 0 of its history, and claim `robots` for it, all or nothing.

        Returns:
            `response` itself; or, where the write's key was used before, the response stored then, and nothing is
            changed.

        Raises:
            KeyReused: the key was used for another request.
            ContentMissing: the scenario was deleted at this moment.
        """
        prior = blob(state.prior)
        columns, entry = written(state, write, None, checksums.NOTHING, checksums.of_blob(prior))
        columns |= {"id": state.id, "scenario": state.scenario, "prior": prior}
        columns["created_at"] = state.created_at.isoformat()
        try:
            with transaction(self._writer) as connection:
                before = stored_response(connection, write.key)
                if before is not None:
                    return before
                connection.execute(_INSERT[sessions], columns | claims.next_order(connection))
                connection.execute(_INSERT[history], entry)
                for robot in sorted(robots):  # in one order, so that two calls cannot wait for each other
                    claims.put(connection, robot, state.id)
                keep_response(connection, write.key, response, self._now())
            return response
        except IntegrityError:  # another process used the same key at the same instant, and was first
            with statement(self._single) as connection:
                before = stored_response(connection, write.key)
            if before is not None:
                return before
            if self.get_scenario(state.scenario) is None:
                raise ContentMissing("scenario", state.scenario) from None
            raise

    def get_session(self, id_: str) -> SessionState | None:
        """Read the newest version of a session; None: there is no such session."""
        with statement(self._single) as connection:
            row = named_row(connection, _BY_ID, id_)
        return _checked(row)

    def newest_session(self) -> SessionState | None:
        """Read the session that was opened last, at its newest version; None: there is no session."""
        with statement(self._single) as connection:
            row = connection.execute(_NEWEST).one_or_none()
        return _checked(row)

    def session_mark(self, id_: str) -> SessionMark | None:
        """Return values that differ after every change of a session, read cheaply; None: there is no such session."""
        # PostgreSQL cannot store a NUL in a text, so no id contains one.
        row = None if "\0" in id_ else first(self._single, self._mark, "by_id", id_)
        return None if row is None else SessionMark(*row)

    def list_sessions(
        self, limit: int, after: str | None, only: Collection[str] | None = None
    ) -> Listed[ListedSession]:
        """List at most `limit` sessions after a cursor, oldest first."""
        with statement(self._single) as connection:
            return list_sessions(connection, limit, after, only)

    def change(self, id_: str, write: Write, step: Step) -> SessionChange:
        """Change a session within one transaction, which is committed on return; see `changing`.

        The step computes the next state of the session and calls `SessionChange.respond`. It runs in any
        thread, and once more where a write that shared its transaction failed. It is not called where the key was used
        before: `state` is then None, and `response` the stored response. An error of the step leaves everything
        unchanged.

        Raises:
            KeyReused: the key was used for another request.
            SessionMissing: there is no such session.
            VersionMismatch: the caller expects another version.
            LookRepeated: a look of this number was counted before; nothing is changed.
        """
        return self._session_writer.change(id_, write, step)

    def history(self, id_: str, after: int, limit: int, most_bytes: int | None = None) -> list[HistoryEntry]:
        """Read at most `limit` versions of a session above `after`, ascending; -1 begins with the prior.

        Stops early, after at least one version, once requests, reports and beliefs add up to `most_bytes` bytes (None:
        no bound). Empty where there is no such session.

        Raises:
            DamagedData: a version differs from what was written.
        """
        with transaction(self._readers) as connection:
            row = named_row(connection, _BY_ID, id_)
            if row is None:
                return []
            checksums.check_session(row)
            return read_history(connection, row, after, limit, most_bytes)

    def delete_session(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> bool:
        """Delete a session with its history; True if it was there, or was deleted under this key before.

        Raises:
            KeyReused: the key was used for another request.
            VersionMismatch: the caller expects another version.
        """
        with transaction(self._writer) as connection:
            row = named_row(connection, _LOCK, id_)
            if stored_response(connection, key) is not None:
                return True
            if row is None:
                return False
            check_version(row.version, if_match)
            is_long = row.version > _AT_ONCE or has_more_responses(connection, id_, _AT_ONCE)
            if is_long:
                connection.execute(_UPDATE, {"by_id": id_, "version": GONE})
            else:
                remove_responses(connection, id_, _AT_ONCE)
                connection.execute(_DELETE, {"by_id": id_})
            notify(connection, [id_])
            keep_response(connection, key, StoredResponse("", row.version), self._now())
        if is_long:
            self._remover.wake()
        return True

    def forget_responses(self, keep_s: float, pause: Callable[[float], object] = time.sleep) -> None:
        """Remove the responses that were stored more than `keep_s` seconds ago, a few at a time.

        Responses that an earlier version of the service stored without a time are dated first: they count from now.

        Args:
            keep_s: seconds for which a response is kept.
            pause: sleeps for so many seconds between two transactions; returns true to end early.
        """
        now = self._now()
        for some in (partial(date_some, at=now), partial(remove_old, before=now - math.ceil(keep_s))):
            more = True
            while more:
                began = time.monotonic()
                with transaction(self._writer) as connection:
                    more = some(connection, rows=_ROWS)
                if pause(time.monotonic() - began):
                    return
        give_back(self._writer, pause)

    def _now(self) -> int:
        return int(self._seconds())


def _checked(row: Row[Any] | None) -> SessionState | None:
    """Return the state in a row of a session; None: there is no row.

    Raises:
        DamagedData: the session differs from what was written.
    """
    if row is None:
        return None
    checksums.check_session(row)
    return session_of(row)
