"""Changes sessions, those of many writers in one transaction: one commit and one sync to the disk for all of them.

A group of writes is one transaction: lock the rows of the sessions, look up the idempotency keys, verify the checksums,
check the versions, apply, append to the histories, store the responses. A write is answered only after that transaction
is committed and on the disk. What one write of a group raises leaves the others alone.

A write whose row another process holds (PostgreSQL) waits for it alone, so that nobody waits for a row while holding
another: writers of several processes cannot wait for each other in a circle.
"""

from collections.abc import Callable, Collection, Sequence
from contextvars import Context, copy_context
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Connection, Engine, Row, Select, bindparam, insert, select, update
from sqlalchemy.exc import IntegrityError

from voa_store import checksums
from voa_store.engines import STATEMENT_ERRORS, WAIT_SECONDS, transaction
from voa_store.errors import SessionMissing, VersionMismatch
from voa_store.grouping import Groups
from voa_store.listening import notify
from voa_store.looks import counted_looks, look_row
from voa_store.prepared import Prepared
from voa_store.records import IdempotencyKey, SessionChange, Step, Write
from voa_store.responses import StoredRows, response_of, response_row, stored_rows
from voa_store.rows import OF_VERSION, Columns, session_of, written
from voa_store.tables import GONE, history, responses, robot_looks, sessions

_MOST = 64
"""Writes of a group: a bound on the memory of a transaction, and on how long its rows are locked."""
_BY_IDS = select(sessions).where(sessions.c.id.in_(bindparam("by_ids", expanding=True)), sessions.c.version > GONE)
_LOCK = _BY_IDS.with_for_update()
_LOCK_FREE = _BY_IDS.with_for_update(skip_locked=True)
_UPDATE = update(sessions).where(sessions.c.id == bindparam("by_id"))
_ADDED = (history, robot_looks, responses)
_NOBODY = IdempotencyKey("", "", "")


@dataclass(eq=False)
class _Pending:
    """A write that waits for its group.

    Attributes:
        id: of the session.
        write: the request.
        step: computes the new state.
        context: of the writer, in which the step runs: its lines in the log name the writer's request.
        result: the change that was committed, or the error of this write; None: it has to be done alone.
    """

    id: str
    write: Write
    step: Step
    context: Context = field(default_factory=copy_context)
    result: SessionChange | Exception | None = None


@dataclass(frozen=True, eq=False)
class _Shared:
    """Facts that the writes of one group share, and the rows of the database that the group changes and adds.

    Attributes:
        before: what is stored under the keys of the writes.
        counted: looks among those of the writes that were counted before.
        at: time of the responses, seconds since 1970.
    """

    before: StoredRows
    counted: Collection[tuple[str, str, int]]
    at: int
    versions: list[Columns] = field(default_factory=list)
    announcements: list[Columns] = field(default_factory=list)
    entries: list[Columns] = field(default_factory=list)
    looks: list[Columns] = field(default_factory=list)
    responses: list[Columns] = field(default_factory=list)


class SessionWriter:
    """Writer of sessions, whose writes at the same time are committed together.

    Args:
        engine: for transactions that write.
        now: returns the time of stored responses, seconds since 1970.
    """

    def __init__(self, engine: Engine, now: Callable[[], int]) -> None:
        dialect = engine.dialect
        self._engine = engine
        self._now = now
        self._announce = Prepared(_UPDATE, ("by_id", "under_way"), dialect)
        self._move_on = Prepared(_UPDATE, ("by_id", *OF_VERSION), dialect)
        self._add = {table: Prepared(insert(table), table.columns.keys(), dialect) for table in _ADDED}
        self._groups = Groups[_Pending](self._together, _MOST, WAIT_SECONDS)

    def change(self, id_: str, write: Write, step: Step) -> SessionChange:
        """Change a session by a step; see `voa_service.ports.Store.change`."""
        pending = _Pending(id_, write, step)
        self._groups.join(pending)
        if pending.result is None:
            self._commit([pending], _LOCK)
        if isinstance(pending.result, SessionChange):
            return pending.result
        raise pending.result or SessionMissing(id_)

    def warm(self) -> None:
        """Connect, and compile the queries of a write, which the first one would have to wait for."""
        with transaction(self._engine) as connection:
            connection.execute(_LOCK_FREE, {"by_ids": [""]}).all()
            stored_rows(connection, [_NOBODY])

    def _together(self, group: Sequence[_Pending]) -> None:
        """Do a group of writes in one transaction, but for those whose rows are locked or missing."""
        try:
            self._commit(group, _LOCK_FREE)
        except STATEMENT_ERRORS:  # by one of them: nothing is committed, and each is done alone
            for pending in group:
                pending.result = None
        except Exception as error:
            for pending in group:
                pending.result = error

    def _commit(self, group: Sequence[_Pending], lock: Select[Any]) -> None:
        """Do writes to different sessions in one transaction; each then has its result.

        Args:
            group: the writes.
            lock: query that locks and reads the sessions' rows.
        """
        with transaction(self._engine) as connection:
            rows = _locked(connection, lock, group)
            before = stored_rows(connection, [pending.write.key for pending in group])
            looks = [(pending.id, pending.write.look) for pending in group if pending.write.look is not None]
            shared = _Shared(before, counted_looks(connection, looks), self._now())
            for pending in group:
                try:
                    pending.result = _changed(pending, rows.get(pending.id), shared)
                except Exception as error:  # of this write alone: it has not used the connection
                    pending.result = error
            self._store(connection, shared)

    def _store(self, connection: Connection, shared: _Shared) -> None:
        """Change and add the rows of a group of writes, and notify other processes of the new versions.

        Raises:
            DamagedData: the version is there already, so that the session's own row is older than what was written.
            IntegrityError: this holds for one of several.
        """
        for change, changed in ((self._announce, shared.announcements), (self._move_on, shared.versions)):
            if changed:
                change.execute(connection, changed)
        for table, added in zip(_ADDED, (shared.entries, shared.looks, shared.responses), strict=True):
            if not added:
                continue
            try:
                self._add[table].execute(connection, added)
            except IntegrityError as error:
                if table is history and len(added) == 1:
                    raise checksums.damaged(added[0]["session"], added[0]["version"]) from error
                raise
        notify(connection, [entry["session"] for entry in shared.entries])


def _locked(connection: Connection, lock: Select[Any], group: Sequence[_Pending]) -> dict[str, Row[Any]]:
    """Lock and read the rows of the sessions of a group."""
    # PostgreSQL cannot store a NUL in a text, so no id contains one.
    ids = [pending.id for pending in group if "\0" not in pending.id]
    return {row.id: row for row in connection.execute(lock, {"by_ids": ids})}


def _changed(pending: _Pending, row: Row[Any] | None, shared: _Shared) -> SessionChange | None:
    """Carry out the step of a write, and add its rows to those of the group; None: its session's row was not locked.

    Raises:
        Exception: the write is refused, or its step failed; nothing was added.
    """
    write = pending.write
    answered = response_of(shared.before, write.key)
    if answered is not None:
        return SessionChange.answered(answered)
    if row is None:
        return None
    prior = checksums.check_session(row)
    check_version(row.version, write.if_match)
    state = session_of(row)
    change = SessionChange(state)
    pending.context.run(pending.step, change, state)
    response, after, belief = change.response, change.after, row.belief
    own, entry, looks = {"by_id": row.id}, None, list[Columns]()
    if after is not None and after.version == row.version:
        own["under_way"] = after.under_way
    elif after is not None:
        columns, entry = written(after, write, change.report, row.newest, prior)
        looks = [] if write.look is None else [look_row(row.id, write.look, shared.counted)]
        own, belief = own | columns, entry["belief"]
    if write.key is not None:
        shared.responses.append(response_row(write.key, response, shared.at, belief))
    if entry is not None:
        shared.versions.append(own)
        shared.entries.append(entry)
        shared.looks.extend(looks)
    elif after is not None:
        shared.announcements.append(own)
    return change


def check_version(version: int, expected: frozenset[int] | None) -> None:
    """Compare a session's version with those that the caller accepts; None: any.

    Raises:
        VersionMismatch: the caller does not accept it.
    """
    if expected is not None and version not in expected:
        raise VersionMismatch(expected, version)
