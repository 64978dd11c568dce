"""The headers of versions and of repeated requests: ETag, If-Match and Idempotency-Key."""

import re
from typing import Annotated

from fastapi import Header
from starlette.datastructures import Headers

IfMatch = Annotated[
    str | None,
    Header(alias="If-Match", description='Version that the session must have, as `"v<version>"`.', examples=['"v3"']),
]
Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        description="Idempotency key: a request that is repeated with it gets the first response and changes nothing.",
        min_length=1,
        max_length=255,
    ),
]

_SESSIONS = "/v1/sessions/"
_STRONG_TAG = re.compile(r'^(?:"v(\d{1,18})"|v(\d{1,18}))$')


def etag(version: int) -> dict[str, str]:
    """Return the ETag header of a version of a session."""
    return {"ETag": f'"v{version}"'}


def version_of(headers: Headers) -> int | None:
    """Return the version in the ETag of a response; None: it has no such header."""
    match = _STRONG_TAG.match(headers.get("etag", ""))
    return None if match is None else int(match[1] or match[2])


def location(session: str) -> dict[str, str]:
    """Return the Location header of a new session."""
    return {"Location": f"{_SESSIONS}{session}"}


def created_id(headers: Headers) -> str | None:
    """Return the id of the session in the Location of a response; None: it has no such header."""
    given = headers.get("location", "")
    return given.removeprefix(_SESSIONS) if given.startswith(_SESSIONS) else None


def versions(if_match: str | None) -> frozenset[int] | None:
    """Return the versions that an If-Match accepts; None: any version. A tag of another form matches no version."""
    if if_match is None or if_match.strip() == "*":
        return None
    matches = (_STRONG_TAG.match(tag.strip()) for tag in if_match.split(","))
    return frozenset(int(match[1] or match[2]) for match in matches if match)
