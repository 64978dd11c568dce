"""Writes to sessions as entrypoints take them in: what was sent, and the caller's name for it."""

import hashlib

from pydantic import BaseModel

from voa_store.records import HistoryKind, IdempotencyKey, RobotLook, Write

ANYONE = "caller:anonymous"
"""The scope of keys of calls that are not about a session yet."""


def scope_of(session: str) -> str:
    """The scope of keys of calls about a session."""
    return f"session:{session}"


def idempotency_key(key: str | None, scope: str, call: str, request: BaseModel | None) -> IdempotencyKey | None:
    """The key of one call; `call` says which, so that the same key on another one is noticed."""
    if key is None:
        return None
    body = "" if request is None else request.model_dump_json()
    return IdempotencyKey(scope, key, hashlib.sha256(f"{call}\n{body}".encode()).hexdigest())


def write_of(
    kind: HistoryKind,
    received: bytes,
    key: IdempotencyKey | None,
    if_match: frozenset[int] | None = None,
    look: RobotLook | None = None,
) -> Write:
    """One write as it came in."""
    # Without a byte order mark: JSON parsers take one before a body, none takes it back.
    return Write(kind, received.decode("utf-8-sig"), key, if_match, look)
