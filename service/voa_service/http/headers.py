"""The headers of the contract: ETag, If-Match, Idempotency-Key."""

import hashlib
import re
from typing import Annotated

from fastapi import Header
from pydantic import BaseModel

from voa_service.ports import HistoryKind, IdempotencyKey, Write

IfMatch = Annotated[
    str | None,
    Header(alias="If-Match", description='Only if the session is at this version, `"v<version>"`.', examples=['"v3"']),
]
Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        description="The caller's name for this call: sent again, it gets the first answer and changes nothing.",
        min_length=1,
        max_length=255,
    ),
]

_STRONG_TAG = re.compile(r'^(?:"v(\d{1,18})"|v(\d{1,18}))$')


def etag(version: int) -> dict[str, str]:
    """The header that names a version."""
    return {"ETag": f'"v{version}"'}


def versions(if_match: str | None) -> frozenset[int] | None:
    """The versions that an If-Match accepts; None: any. A tag that is none of ours matches nothing."""
    if if_match is None or if_match.strip() == "*":
        return None
    found = (_STRONG_TAG.match(tag.strip()) for tag in if_match.split(","))
    return frozenset(int(match[1] or match[2]) for match in found if match)


def idempotency_key(key: str | None, scope: str, call: str, request: BaseModel | None) -> IdempotencyKey | None:
    """The key of one call; `call` says which, so that the same key on another one is noticed."""
    if key is None:
        return None
    body = "" if request is None else request.model_dump_json()
    return IdempotencyKey(scope, key, hashlib.sha256(f"{call}\n{body}".encode()).hexdigest())


def write_of(kind: HistoryKind, received: bytes, key: IdempotencyKey | None, if_match: str | None = None) -> Write:
    """One write as it came in."""
    # Without a byte order mark: JSON parsers take one before a body, none takes it back.
    return Write(kind, received.decode("utf-8-sig"), key, versions(if_match))
