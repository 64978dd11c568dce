"""Lists in pages, with an opaque cursor."""

from collections.abc import Callable
from typing import Any, TypeVar

from voa_service.failures import InvalidRequest
from voa_service.ports import Listed

T = TypeVar("T")
M = TypeVar("M")

_LONGEST_CURSOR = 18  # digits of a 63-bit integer


def page(
    listing: Callable[[int, str | None], Listed[T]], make: Callable[[T], M], limit: int, after: str | None
) -> dict[str, Any]:
    """The fields of one page of a listing: `items` as messages, and `next`.

    Raises:
        Failure: `after` is not a cursor of ours.
    """
    if after is not None:
        position(after)
    found = listing(limit, after)
    return {"items": [make(item) for item in found.items], "next": found.next}


def position(cursor: str) -> int:
    """The place that a cursor of ours means.

    Raises:
        Failure: it is none of ours.
    """
    if not (cursor.isascii() and cursor.isdigit() and len(cursor) <= _LONGEST_CURSOR):
        raise InvalidRequest(f"after: expected the `next` of a page, got {cursor[:40]!r}")
    return int(cursor)
