"""The headers of versions and of repeated requests: ETag, If-Match and Idempotency-Key."""

import re
from typing import Annotated

from fastapi import Header

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

_STRONG_TAG = re.compile(r'^(?:"v(\d{1,18})"|v(\d{1,18}))$')


def etag(version: int) -> dict[str, str]:
    """Return the ETag header of a version of a session."""
    return {"ETag": f'"v{version}"'}


def versions(if_match: str | None) -> frozenset[int] | None:
    """Return the versions that an If-Match accepts; None: any version. A tag of another form matches no version."""
    if if_match is None or if_match.strip() == "*":
        return None
    matches = (_STRONG_TAG.match(tag.strip()) for tag in if_match.split(","))
    return frozenset(int(match[1] or match[2]) for match in matches if match)
