"""Idempotency keys, and the responses that are stored under them."""

from sqlalchemy import Connection, bindparam, insert, select

from voa_store.errors import KeyReused
from voa_store.records import IdempotencyKey, StoredResponse
from voa_store.tables import responses

_INSERT = insert(responses)
_STORED = select(responses).where(responses.c.scope == bindparam("by_scope"), responses.c.key == bindparam("by_key"))


def stored_response(connection: Connection, key: IdempotencyKey | None) -> StoredResponse | None:
    """Read the response stored under a key; None: there is no key, or it has not been used.

    Raises:
        KeyReused: the key was used for another request.
    """
    if key is None or "\0" in key.scope:  # PostgreSQL cannot store a NUL in a text, so no scope contains one
        return None
    row = connection.execute(_STORED, {"by_scope": key.scope, "by_key": key.key}).one_or_none()
    if row is None:
        return None
    if row.fingerprint != key.fingerprint:
        raise KeyReused(key.key)
    return StoredResponse(row.body, row.version)


def keep_response(connection: Connection, key: IdempotencyKey | None, response: StoredResponse) -> None:
    """Store a response under its key, if the write has one."""
    if key is not None:
        named = {"scope": key.scope, "key": key.key, "fingerprint": key.fingerprint}
        connection.execute(_INSERT, named | {"body": response.body, "version": response.version})
