"""Idempotency keys, and what was answered under them."""

from sqlalchemy import Connection, bindparam, insert, select

from voa_service.failures import IdempotencyKeyReused
from voa_service.ports import Answered, IdempotencyKey
from voa_store.tables import answers

_INSERT = insert(answers)
_ANSWERED = select(answers).where(answers.c.scope == bindparam("by_scope"), answers.c.key == bindparam("by_key"))


def answered(connection: Connection, key: IdempotencyKey | None) -> Answered | None:
    """Read what was answered under a key before.

    Raises:
        Failure: the key came with another request.
    """
    if key is None or "\0" in key.scope:  # PostgreSQL has no text with a NUL in it, so nothing is named so
        return None
    row = connection.execute(_ANSWERED, {"by_scope": key.scope, "by_key": key.key}).one_or_none()
    if row is None:
        return None
    if row.fingerprint != key.fingerprint:
        raise IdempotencyKeyReused(f"Idempotency-Key {key.key!r} was used for another request: take a new key")
    return Answered(row.body, row.version)


def remember(connection: Connection, key: IdempotencyKey | None, answer: Answered) -> None:
    """Keep an answer under its key, if it has one."""
    if key is not None:
        named = {"scope": key.scope, "key": key.key, "fingerprint": key.fingerprint}
        connection.execute(_INSERT, named | {"body": answer.body, "version": answer.version})
