"""The store on a relational database.

A write is one transaction: lock the session (SQLite: BEGIN IMMEDIATE, one writer; PostgreSQL: its row), look for the
idempotency key, check the version, apply, append to the history, keep the answer. Writers wait for each other and
never retry. What was answered is committed and synced.
"""

from collections.abc import Callable, Hashable, Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any, TypeVar

from sqlalchemy import (
    BigInteger,
    Connection,
    Row,
    Select,
    Table,
    bindparam,
    delete,
    insert,
    literal,
    select,
    text,
    update,
)
from sqlalchemy.exc import IntegrityError

from voa_service.failures import KEY_REUSED, STALE, Failure
from voa_service.ports import (
    Answered,
    HistoryEntry,
    IdempotencyKey,
    Listed,
    RobotLook,
    SessionState,
    Step,
    StoredObject,
    StoredScenario,
    Upload,
    Write,
)
from voa_service.store import claims
from voa_service.store.engines import connect, first, statement, transaction
from voa_service.store.listening import CHANNEL, Listener
from voa_service.store.looks import count_look, newest_looks
from voa_service.store.migrate import is_current, migrate
from voa_service.store.rows import blob, entry_of, object_of, scenario_of, session_columns, session_of
from voa_service.store.tables import answers, history, objects, scenarios, sessions, uploads

T = TypeVar("T")

# Built once: SQLAlchemy then finds their compiled form without looking at them anew.
_INSERT = {table: insert(table) for table in (objects, scenarios, sessions, history, answers, uploads)}
_BY_ID = {table: select(table).where(table.c.id == bindparam("by_id")) for table in (objects, scenarios, sessions)}
_LOCK_SESSION = _BY_ID[sessions].with_for_update()
_UPDATE_SESSION = update(sessions).where(sessions.c.id == bindparam("by_id"))
_DELETE_SESSION = delete(sessions).where(sessions.c.id == bindparam("by_id"))
_HISTORY = (
    select(history)
    .where(history.c.session == bindparam("by_id"), history.c.version > bindparam("by_version", type_=BigInteger))
    .order_by(history.c.version)
    .limit(bindparam("by_limit"))
)
_MARK = select(sessions.c.version, sessions.c.updated_at).where(sessions.c.id == bindparam("by_id"))
_NOTIFY = text("SELECT pg_notify(:channel, :session)")
_UPLOADED = (
    select(objects)
    .join(uploads, uploads.c.object == objects.c.id)
    .where(*(uploads.c[name] == bindparam(f"by_{name}") for name in ("sha256", "type", "scale", "up")))
)
_ANSWERED = select(answers).where(answers.c.scope == bindparam("by_scope"), answers.c.key == bindparam("by_key"))


class SqlStore:
    """`ports.Store` on a database URL, `sqlite:///voa.db` or `postgresql://user@host/voa`."""

    def __init__(self, url: str) -> None:
        self._engines = connect(url)
        self._writer, self._readers, self._single = self._engines
        self._mark = _MARK.compile(dialect=self._single.dialect)
        self._tells = self._writer.dialect.name == "postgresql"
        self._listener: Listener | None = None
        migrate(self._writer)

    def ping(self) -> None:
        """Read, and see whether the tables are this version's."""
        with statement(self._single) as connection:
            if not is_current(connection):
                raise RuntimeError("the tables are those of another version of the service")

    def close(self) -> None:
        """Close every connection."""
        if self._listener is not None:
            self._listener.close()
        self._engines.dispose()

    def listen(self, moved: Callable[[str], None]) -> None:
        """See `ports.Store`."""
        if self._tells:
            url = self._writer.url.set(drivername="postgresql")
            self._listener = Listener(url.render_as_string(hide_password=False), moved)

    def put_object(self, stored: StoredObject) -> tuple[StoredObject, bool]:
        """See `ports.Store`."""
        row = {
            "id": stored.object.digest,
            "name": stored.name,
            "created_at": stored.created_at.isoformat(),
            "vertices": stored.object.vertices.astype("<f8").tobytes(),
            "faces": stored.object.faces.astype("<i4").tobytes(),
            "up": stored.up,
        }
        there, new = self._put(objects, row)
        return object_of(there), new

    def get_object(self, id_: str) -> StoredObject | None:
        """See `ports.Store`."""
        row = self._get(objects, id_)
        return None if row is None else object_of(row)

    def list_objects(self, limit: int, after: str | None) -> Listed[StoredObject]:
        """See `ports.Store`."""
        return self._list(objects, object_of, limit, after)

    def put_upload(self, upload: Upload, object_: str) -> None:
        """See `ports.Store`."""
        if self.find_upload(upload) is not None:
            return
        with suppress(IntegrityError), transaction(self._writer) as connection:  # another process was first
            connection.execute(_INSERT[uploads], {**asdict(upload), "object": object_})

    def find_upload(self, upload: Upload) -> StoredObject | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            named = {f"by_{name}": value for name, value in asdict(upload).items()}
            row = connection.execute(_UPLOADED, named).one_or_none()
        return None if row is None else object_of(row)

    def put_scenario(self, stored: StoredScenario) -> tuple[StoredScenario, bool]:
        """See `ports.Store`."""
        row = {"id": stored.id, "name": stored.name, "created_at": stored.created_at.isoformat(), "body": stored.body}
        there, new = self._put(scenarios, row)
        return scenario_of(there), new

    def get_scenario(self, id_: str) -> StoredScenario | None:
        """See `ports.Store`."""
        row = self._get(scenarios, id_)
        return None if row is None else scenario_of(row)

    def list_scenarios(self, limit: int, after: str | None) -> Listed[StoredScenario]:
        """See `ports.Store`."""
        return self._list(scenarios, scenario_of, limit, after)

    def get_answer(self, key: IdempotencyKey) -> Answered | None:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return _answered(connection, key)

    def create_session(
        self, state: SessionState, write: Write, answer: Answered, robots: Sequence[str] = ()
    ) -> Answered:
        """See `ports.Store`."""
        try:
            with transaction(self._writer) as connection:
                before = _answered(connection, write.key)
                if before is not None:
                    return before
                named = {"id": state.id, "scenario": state.scenario, **claims.next_order(connection)}
                connection.execute(_INSERT[sessions], named | session_columns(state))
                _append(connection, state, write, None)
                for robot in sorted(robots):  # in one order, so that nobody waits for each other
                    claims.put(connection, robot, state.id)
                _remember(connection, write.key, answer)
            return answer
        except IntegrityError:  # another process took the same key at the same instant, and was first
            with statement(self._single) as connection:
                first = _answered(connection, write.key)
            if first is None:
                raise
            return first

    def get_session(self, id_: str) -> SessionState | None:
        """See `ports.Store`."""
        row = self._get(sessions, id_)
        return None if row is None else session_of(row)

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

    def list_sessions(self, limit: int, after: str | None) -> Listed[SessionState]:
        """See `ports.Store`."""
        return self._list(sessions, session_of, limit, after)

    def change_session(self, id_: str, write: Write, step: Callable[[SessionState], Step]) -> Answered | None:
        """See `ports.Store`."""
        with transaction(self._writer) as connection:
            state = _locked(connection, id_)
            before = _answered(connection, write.key)
            if before is not None or state is None:
                return before
            _check_version(state, write.if_match)
            change = step(state)
            if change.after is not None:
                connection.execute(_UPDATE_SESSION, {"by_id": id_, **session_columns(change.after)})
                _append(connection, change.after, write, change.report)
                if write.look is not None:
                    count_look(connection, id_, write.look)
                self._tell(connection, id_)
            _remember(connection, write.key, change.answer)
        return change.answer

    def robot_looks(self, id_: str, robot: str, limit: int) -> list[RobotLook]:
        """See `ports.Store`."""
        with statement(self._single) as connection:
            return newest_looks(connection, id_, robot, limit)

    def history(self, id_: str, after: int, limit: int) -> list[HistoryEntry]:
        """See `ports.Store`."""
        with transaction(self._readers) as connection:
            row = _named(connection, _BY_ID[sessions], id_)
            if row is None:
                return []
            found = connection.execute(_HISTORY, {"by_id": id_, "by_version": after, "by_limit": limit}).all()
        return [entry_of(session_of(row), entry) for entry in found]

    def delete_session(self, id_: str, key: IdempotencyKey | None, if_match: frozenset[int] | None) -> bool:
        """See `ports.Store`."""
        with transaction(self._writer) as connection:
            state = _locked(connection, id_)
            if _answered(connection, key) is not None:
                return True
            if state is None:
                return False
            _check_version(state, if_match)
            connection.execute(_DELETE_SESSION, {"by_id": id_})
            self._tell(connection, id_)
            _remember(connection, key, Answered("", state.version))
        return True

    def _tell(self, connection: Connection, id_: str) -> None:
        """Let other processes know when this is committed."""
        if self._tells:
            connection.execute(_NOTIFY, {"channel": CHANNEL, "session": id_})

    def _put(self, table: Table, row: dict[str, Any]) -> tuple[Row[Any], bool]:
        """Insert a row named by its content, unless it is there; the row that is there then, and if it is new."""
        named = {"by_id": row["id"]}
        try:
            with transaction(self._writer) as connection:
                there = connection.execute(_BY_ID[table], named).one_or_none()
                if there is not None:
                    return there, False
                connection.execute(_INSERT[table], row)
                return connection.execute(_BY_ID[table], named).one(), True
        except IntegrityError:  # another process stored the same content at the same instant
            with statement(self._single) as connection:
                return connection.execute(_BY_ID[table], named).one(), False

    def _get(self, table: Table, id_: str) -> Row[Any] | None:
        with statement(self._single) as connection:
            return _named(connection, _BY_ID[table], id_)

    def _list(self, table: Table, make: Callable[[Row[Any]], T], limit: int, after: str | None) -> Listed[T]:
        query = select(table).order_by(table.c.seq).limit(limit + 1)
        if after is not None:
            query = query.where(table.c.seq > literal(int(after), BigInteger))
        with statement(self._single) as connection:
            rows = connection.execute(query).all()
        more = len(rows) > limit
        return Listed([make(row) for row in rows[:limit]], str(rows[limit - 1].seq) if more else None)


def _named(connection: Connection, query: Select[Any], id_: str) -> Row[Any] | None:
    """The row of an id. PostgreSQL has no text with a NUL in it, so nothing is named so."""
    return None if "\0" in id_ else connection.execute(query, {"by_id": id_}).one_or_none()


def _locked(connection: Connection, id_: str) -> SessionState | None:
    row = _named(connection, _LOCK_SESSION, id_)
    return None if row is None else session_of(row)


def _check_version(state: SessionState, seen: frozenset[int] | None) -> None:
    if seen is not None and state.version not in seen:
        wanted = ", ".join(f"v{version}" for version in sorted(seen)) or "none that exists"
        raise Failure(
            STALE,
            f"If-Match asks for {wanted}, the session is at v{state.version}: read it again",
            version=state.version,
        )


def _answered(connection: Connection, key: IdempotencyKey | None) -> Answered | None:
    """What was answered under the key before."""
    if key is None or "\0" in key.scope:  # see `_named`
        return None
    row = connection.execute(_ANSWERED, {"by_scope": key.scope, "by_key": key.key}).one_or_none()
    if row is None:
        return None
    if row.fingerprint != key.fingerprint:
        raise Failure(KEY_REUSED, f"Idempotency-Key {key.key!r} was used for another request: take a new key")
    return Answered(row.body, row.version)


def _remember(connection: Connection, key: IdempotencyKey | None, answer: Answered) -> None:
    if key is not None:
        named = {"scope": key.scope, "key": key.key, "fingerprint": key.fingerprint}
        connection.execute(_INSERT[answers], named | {"body": answer.body, "version": answer.version})


def _append(connection: Connection, state: SessionState, write: Write, report: str | None) -> None:
    entry = {
        "session": state.id,
        "version": state.version,
        "kind": write.kind,
        "at": state.updated_at.isoformat(),
        "request": write.request,
        "report": report,
        "belief": blob(state.belief),
        "last_fit_rmsd_mm": state.last_fit_rmsd_mm,
    }
    connection.execute(_INSERT[history], entry)
