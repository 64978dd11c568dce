"""Idempotency keys of writes, and the record of a write that the store keeps with the history."""

import hashlib

from pydantic import BaseModel

from voa_msgs.reading import utf8_text
from voa_store.records import IdempotencyKey, RobotLook, Write, WriteKind


def scope_of(session: str) -> str:
    """Return the scope of the keys of calls to a session: a key is unique within its scope."""
    return f"session:{session}"


def scope_of_caller(name: str) -> str:
    """Return the scope of the keys of calls that do not concern a session yet: a key is unique for its caller.

    Args:
        name: of the caller, which stays when its API key is replaced.
    """
    return f"caller:{name}"


def idempotency_key(key: str | None, scope: str, call: str, request: BaseModel | None) -> IdempotencyKey | None:
    """Make the idempotency key of a call, with a digest by which the reuse for another request is detected.

    Args:
        key: as the caller sent it; None: the caller sent no key, and the result is None.
        scope: in which the key is unique, see `scope_of`.
        call: kind of the call, part of the digest.
        request: body of the call, part of the digest; None where the call has no body.
    """
    if key is None:
        return None
    body = "" if request is None else request.model_dump_json()
    return IdempotencyKey(scope, key, hashlib.sha256(f"{call}\n{body}".encode()).hexdigest())


def write_of(
    kind: WriteKind,
    received: bytes,
    key: IdempotencyKey | None,
    if_match: frozenset[int] | None = None,
    look: RobotLook | None = None,
) -> Write:
    """Make the record of a write: what the history keeps of the request, and the conditions under which it is done.

    Args:
        kind: of the history entry that the write makes.
        received: body of the request in UTF-8, kept as it was received.
        key: idempotency key, if the caller sent one.
        if_match: versions of the session that the caller accepts; None: any.
        look: the robot's look that a scan is, of a robot whose ROS 2 topics are mapped.
    """
    # JSON parsers accept a byte order mark before a body; text with one inside would not be read back.
    return Write(kind, utf8_text(received), key, if_match, look)
