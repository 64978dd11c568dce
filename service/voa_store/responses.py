"""Idempotency keys, and the responses that are stored under them until they are too old or their session is deleted.

Responses that report a session are packed (`packing`) with the belief that its history has at that version.
"""

from collections.abc import Iterable
from typing import Any

from sqlalchemy import Connection, and_, bindparam, delete, insert, select, update

from voa_store import checksums
from voa_store.errors import KeyReused
from voa_store.packing import is_packed, pack, unpack
from voa_store.records import IdempotencyKey, StoredResponse
from voa_store.tables import history, responses, sessions

_SESSION = "session:"
_INSERT = insert(responses)
_AT_VERSION = and_(history.c.session == bindparam("by_session"), history.c.version == responses.c.version)
_STORED = (
    select(responses.c.fingerprint, responses.c.body, responses.c.version, history.c.belief)
    .select_from(responses.outerjoin(history, _AT_VERSION))
    .where(responses.c.scope == bindparam("by_scope"), responses.c.key == bindparam("by_key"))
)
_KEY = (responses.c.scope == bindparam("by_scope"), responses.c.key == bindparam("by_key"))
_DELETE = delete(responses).where(*_KEY)
_DATE = update(responses).where(*_KEY)
_OF_SESSION = and_(responses.c.scope == bindparam("by_scope"), responses.c.body != "")
_KEYS = (
    select(responses.c.scope, responses.c.key)
    .where(_OF_SESSION)
    .limit(bindparam("by_limit"))
    .with_for_update(skip_locked=True)  # PostgreSQL: another replica may be removing the same rows
)
_OLD = (
    select(responses.c.scope, responses.c.key)
    .where(responses.c.at < bindparam("by_at"))
    .order_by(responses.c.at)
    .limit(bindparam("by_limit"))
    .with_for_update(skip_locked=True)
)
_UNDATED = (
    select(responses.c.scope, responses.c.key, sessions.c.id, responses.c.body == "")
    .select_from(responses.outerjoin(sessions, responses.c.scope == _SESSION + sessions.c.id))
    .where(responses.c.at.is_(None))
    .limit(bindparam("by_limit"))
    .with_for_update(of=responses, skip_locked=True)
)


def stored_response(connection: Connection, key: IdempotencyKey | None) -> StoredResponse | None:
    """Read the response stored under a key; None: there is no key, or it has not been used, or its session is gone.

    Raises:
        KeyReused: the key was used for another request.
        DamagedData: the response, or the belief that it reports, differs from what was written.
    """
    if key is None or "\0" in key.scope:  # PostgreSQL cannot store a NUL in a text, so no scope contains one
        return None
    session = key.scope.removeprefix(_SESSION)
    named = {"by_scope": key.scope, "by_key": key.key, "by_session": session}
    row = connection.execute(_STORED, named).one_or_none()
    if row is None:
        return None
    if row.fingerprint != key.fingerprint:
        raise KeyReused(key.key)
    if not is_packed(row.body):
        return StoredResponse(row.body, row.version)
    if row.belief is None:  # the history of a deleted session is being removed, and its responses with it
        return None
    try:
        return StoredResponse(unpack(row.body, row.belief), row.version)
    except ValueError as error:
        raise checksums.damaged(session, row.version) from error


def keep_response(
    connection: Connection, key: IdempotencyKey | None, response: StoredResponse, at: int, belief: bytes | None = None
) -> None:
    """Store a response under its key, if the write has one.

    Args:
        connection: of the write's transaction.
        key: of the write.
        response: to it.
        at: time of the write, seconds since 1970.
        belief: of the session, whose id is the key's scope, at the response's version as the history has it; None: the
            response does not report a session.
    """
    if key is not None:
        body = response.body if belief is None else pack(response.body, belief)
        named = {"scope": key.scope, "key": key.key, "fingerprint": key.fingerprint, "at": at}
        connection.execute(_INSERT, named | {"body": body, "version": response.version})


def has_more_responses(connection: Connection, session: str, rows: int) -> bool:
    """True if more than so many responses are stored for the calls of a session."""
    named = {"by_scope": _SESSION + session, "by_limit": rows + 1}
    return len(connection.execute(_KEYS, named).all()) > rows


def remove_responses(connection: Connection, session: str, rows: int) -> bool:
    """Remove at most so many responses to the calls of a deleted session; False: there was none.

    The response to its deletion, which has no body, stays until it is too old: the call may be repeated.
    """
    named = {"by_scope": _SESSION + session, "by_limit": rows}
    return _removed(connection, connection.execute(_KEYS, named).all())


def remove_old(connection: Connection, before: int, rows: int) -> bool:
    """Remove at most so many responses from before a time, seconds since 1970; False: there was none."""
    return _removed(connection, connection.execute(_OLD, {"by_at": before, "by_limit": rows}).all())


def date_some(connection: Connection, at: int, rows: int) -> bool:
    """Date at most so many responses that have no time, and remove those of deleted sessions; False: there was none.

    Args:
        connection: of a transaction.
        at: present time, seconds since 1970.
        rows: bound on the responses.
    """
    undated = connection.execute(_UNDATED, {"by_limit": rows}).all()
    orphans = [
        (scope, key) for scope, key, session, empty in undated if scope.startswith(_SESSION) and not (session or empty)
    ]
    _removed(connection, orphans)
    kept = [(scope, key) for scope, key, *_ in undated if (scope, key) not in set(orphans)]
    if kept:
        connection.execute(_DATE, [{"by_scope": scope, "by_key": key, "at": at} for scope, key in kept])
    return bool(undated)


def _removed(connection: Connection, keys: Iterable[Any]) -> bool:
    named = [{"by_scope": scope, "by_key": key} for scope, key in keys]
    if named:
        connection.execute(_DELETE, named)
    return bool(named)
