"""The store on a relational database.

A write is one transaction: lock the session (SQLite: BEGIN IMMEDIATE, one writer; PostgreSQL: its row), look for the
idempotency key, check the version, apply, append to the history, keep the answer. Writers wait for each other and
never retry. What was answered is committed and synced.
"""

from collections.abc import Callable, Hashable, Sequence
from typing import Any

from sqlalchemy import Connection, Row, bindparam, delete, insert, literal_column, select, text, update
from sqlalchemy.exc import IntegrityError

from voa_service.failures import StaleVersion
from voa_service.ports import (
    Answered,
    HistoryEntry,
    IdempotencyKey,
    Listed,
    ListedSession,
    RobotLook,
    SessionState,
    Step,
    Write,
)
from voa_store import checksums, claims
from voa_store.contents import Contents, named_row
from voa_store.engines import connect, first, statement, transaction
from voa_store.histories import read_history
from voa_store.keys import answered, remember
from voa_store.listening import CHANNEL, Listener
from voa_store.looks import count_look, newest_looks
from voa_store.migrate import is_current, migrate
from voa_store.probing import Probe
from voa_store.removal import Remover
from voa_store.rows import blob, session_of, written
from voa_store.summaries import list_sessions
from voa_store.tables import GONE, history, sessions

PATIENCE_SECONDS = 4.0
_AT_ONCE = 64  # versions of a session that are removed in the transaction that deletes it

# Built once: SQLAlchemy then finds their compiled form without looking at them anew.
_INSERT = {table: insert(table) for table in (sessions, history)}
_BY_ID = select(sessions).where(sessions.c.id == bindparam("by_id"), sessions.c.version > GONE)
_LOCK = _BY_ID.with_for_update()
_UPDATE = update(sessions).where(sessions.c.id == bindparam("by_id"))
_DELETE = delete(sessions).where(sessions.c.id == bindparam("by_id"))
_MARK = select(sessions.c.version, sessions.c.updated_at).where(
    sessions.c.id == bindparam("by_id"), sessions.c.version > literal_column(str(GONE))
)
_NOTIFY = text("SELECT pg_notify(:channel, :session)")


class SqlStore(Contents):
    """`ports.Store` on a database URL, `sqlite:///voa.db` or `postgresql://user@host/voa`.

    Args:
        url: of the database.
        patience_s: how long PostgreSQL may be silent before a call fails.
    """

    def __init__(self, url: str, patience_s: float = PATIENCE_SECONDS) -> None:
        self._engines = connect(url, patience_s)
        super().__init__(self._engines)
        self._readers = self._engines.readers
        self._mark = _MARK.compile(dialect=self._single.dialect)
        self._tells = self._writer.dialect.name == "postgresql"
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
        """See `ports.Store`."""
        return self._engines.software

    @property
    def troubles(self) -> int:
        """See `ports.Store`."""
        return self._engines.troubles.count

    def ping(self) -> None:
        """Read, write, and see whether the tables are this version's."""
        with statement(self._single) as connection:
            if not is_current(connection):
                raise RuntimeError("the tables are those of another version of the service")
        self._probe.write()

    def close(self) -> None:
        """Close every connection."""
        if self._listener is not None:
            self._listener.close()
        self._remover.close()
        self._engines.dispose()

    def listen(self, moved: Callable[[str], None]) -> None:
        """See `ports.Store`."""
        if self._tells:
            self._listener = Listener(self._engines.parameters, moved)

    def get_answer(self, key: IdempotencyKey) -> Answered | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return answered(connection, key)

    def create_session(
        self, state: SessionState, write: Write, answer: Answered, robots: Sequence[str] = ()
    ) -> Answered:
        """See `ports.Store`."""
        prior = blob(state.prior)
        columns, entry = written(state, write, None, checksums.NOTHING, checksums.of_blob(prior))
        columns |= {"id": state.id, "scenario": state.scenario, "prior": prior}
        columns["created_at"] = state.created_at.isoformat()
        try:
            with transaction(self._writer) as connection:
                before = answered(connection, write.key)
                if before is not None:
                    return before
                connection.execute(_INSERT[sessions], columns | claims.next_order(connection))
                connection.execute(_INSERT[history], entry)
                for robot in sorted(robots):  # in one order, so that nobody waits for each other
                    claims.put(connection, robot, state.id)
                remember(connection, write.key, answer)
            return answer
        except IntegrityError:  # another process took the same key at the same instant, and was first
            with statement(self._single) as connection:
                was = answered(connection, write.key)
            if was is None:
                raise
            return was

    def get_session(self, id_: str) -> SessionState | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            row = named_row(connection, _BY_ID, id_)
        if row is None:
            return None
        checksums.check_session(row)
        return session_of(row)

    def session_mark(self, id_: str) -> Hashable | None:
        """See `ports.Store`."""
        # PostgreSQL has no text with a NUL in it, so nothing is named so.
        return None if "\0" in id_ else first(self._single, self._mark, "by_id", id_)

    def robot_session(self, robot: str, scenario: str) -> str | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return claims.find(connection, robot, scenario).id

    def settle_robot(self, robot: str, scenario: str) -> str | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            found = claims.find(connection, robot, scenario)
        if found.settled or found.session is None:  # nothing to write: the usual case
            return found.id
        with transaction(self._writer) as connection:
            return claims.settle(connection, robot, scenario)

    def claim_robot(self, robot: str, session: str | None) -> bool:
        """See `ports.Store`."""
        with transaction(self._writer) as connection:
            return claims.put(connection, robot, session)

    def list_sessions(self, limit: int, after: str | None) -> Listed[ListedSession]:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return list_sessions(connection, limit, after)

    def change_session(self, id_: str, write: Write, step: Callable[[SessionState], Step]) -> Answered | None:
        """See `ports.Store`."""
        with transaction(self._writer) as connection:
            row = named_row(connection, _LOCK, id_)
            before = answered(connection, write.key)
            if before is not None or row is None:
                return before
            prior = checksums.check_session(row)
            _check_version(row, write.if_match)
            change = step(session_of(row))
            if change.after is not None:
                columns, entry = written(change.after, write, change.report, row.newest, prior)
                connection.execute(_UPDATE, {"by_id": id_, **columns})
                connection.execute(_INSERT[history], entry)
                if write.look is not None:
                    count_look(connection, id_, write.look)
                self._tell(connection, id_)
            remember(connection, write.key, change.answer)
        return change.answer

    def robot_looks(self, id_: str, robot: str, limit: int) -> list[RobotLook]:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return newest_looks(connection, id_, robot, limit)

    def history(self, id_: str, after: int, limit: int, most_bytes: int | None = None) -> list[HistoryEntry]:
        """See `ports.Store`."""
        with transaction(self._readers) as connection:
            row = named_row(connection, _BY_ID, id_)
            if row is None:
                return []
            checksums.check_session(row)
            return read_history(connection, row, after, limit, most_bytes)

    def delete_session(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> bool:
        """See `ports.Store`."""
        with transaction(self._writer) as connection:
            row = named_row(connection, _LOCK, id_)
            if answered(connection, key) is not None:
                return True
            if row is None:
                return False
            _check_version(row, if_match)
            later = row.version > _AT_ONCE
            if later:
                connection.execute(_UPDATE, {"by_id": id_, "version": GONE})
            else:
                connection.execute(_DELETE, {"by_id": id_})
            self._tell(connection, id_)
            remember(connection, key, Answered("", row.version))
        if later:
            self._remover.wake()
        return True

    def _tell(self, connection: Connection, id_: str) -> None:
        """Let other processes know when this is committed."""
        if self._tells:
            connection.execute(_NOTIFY, {"channel": CHANNEL, "session": id_})


def _check_version(row: Row[Any], seen: frozenset[int] | None) -> None:
    if seen is not None and row.version not in seen:
        wanted = ", ".join(f"v{version}" for version in sorted(seen)) or "none that exists"
        raise StaleVersion(
            f"If-Match asks for {wanted}, the session is at v{row.version}: read it again", version=row.version
        )
