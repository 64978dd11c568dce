"""Idempotency keys, and the responses that are stored under them until they are too old or their session is deleted.

Responses that report a session are packed (`packing`) with the belief that its history has at that version.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from sqlalchemy import (
    Connection,
    and_,
    bindparam,
    delete,
    func,
    insert,
    literal_column,
    select,
    tuple_,
    update,
)

from voa_store import checksums
from voa_store.errors import KeyReused
from voa_store.packing import is_packed, pack, unpack
from voa_store.records import IdempotencyKey, StoredResponse
from voa_store.rows import Columns
from voa_store.tables import history, responses, sessions

StoredRows = Mapping[tuple[str, str], Any]
"""Rows of stored responses, with the beliefs that they report, by scope and key."""

_SESSION = "session:"
_INSERT = insert(responses)
_OF_SCOPE = func.substr(responses.c.scope, literal_column(str(len(_SESSION) + 1)))
_AT_VERSION = and_(history.c.session == _OF_SCOPE, history.c.version == responses.c.version)
_NAMED = tuple_(responses.c.scope, responses.c.key)
_STORED = (
    select(
        *(responses.c[name] for name in ("scope", "key", "fingerprint", "body", "version")),
        history.c.belief,
    )
    .select_from(responses.outerjoin(history, _AT_VERSION))
    .where(_NAMED.in_(bindparam("by_keys", expanding=True)))
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
    return response_of(stored_rows(connection, [key]), key)


def stored_rows(connection: Connection, keys: Iterable[IdempotencyKey | None]) -> StoredRows:
    """Read what is stored under keys, for `response_of`; None is no key."""
    # PostgreSQL cannot store a NUL in a text, so no scope contains one.
    named = [(key.scope, key.key) for key in keys if key is not None and "\0" not in key.scope]
    if not named:
        return {}
    return {(row.scope, row.key): row for row in connection.execute(_STORED, {"by_keys": named})}


def response_of(rows: StoredRows, key: IdempotencyKey | None) -> StoredResponse | None:
    """Return the response stored under a key; None: there is no key, or it has not been used, or its session is gone.

    Args:
        rows: by `stored_rows`, for this key and others.
        key: of a write.

    Raises:
        KeyReused: the key was used for another request.
        DamagedData: the response, or the belief that it reports, differs from what was written.
    """
    row = None if key is None else rows.get((key.scope, key.key))
    if key is None or row is None:
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
        raise checksums.damaged(key.scope.removeprefix(_SESSION), row.version) from error


def keep_response(connection: Connection, key: IdempotencyKey | None, response: StoredResponse, at: int) -> None:
    """Store a response that reports no belief under its key, if the write has one.

    Args:
        connection: of the write's transaction.
        key: of the write.
        response: to it.
        at: time of the write, seconds since 1970.
    """
    if key is not None:
        connection.execute(_INSERT, response_row(key, response, at))


def response_row(key: IdempotencyKey, response: StoredResponse, at: int, belief: bytes | None = None) -> Columns:
    """Return the row of a response to be stored under a key.

    Args:
        key: of the write.
        response: to it.
        at: time of the write, seconds since 1970.
        belief: of the session, whose id is the key's scope, at the response's version as the history has it; None: the
            response does not report a session.
    """
    body = response.body if belief is None else pack(response.body, belief)
    named = {"scope": key.scope, "key": key.key, "fingerprint": key.fingerprint, "at": at}
    return named | {"body": body, "version": response.version}


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
