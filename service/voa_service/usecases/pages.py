"""Pages of lists, with an opaque cursor."""

from collections.abc import Callable
from typing import Any, TypeVar

from voa_service.failures import InvalidRequest
from voa_store.records import Listed

T = TypeVar("T")
M = TypeVar("M")

_LONGEST_CURSOR = 18  # digits of a 63-bit integer


def page(
    listing: Callable[[int, str | None], Listed[T]], make: Callable[[T], M], limit: int, after: str | None
) -> dict[str, Any]:
    """Return the fields of one page of a list: `items` as messages, and `next`.

    Args:
        listing: reads at most so many items after a cursor.
        make: converts an item to a message.
        limit: most items of the page.
        after: `next` of the page before; None: from the start.

    Raises:
        InvalidRequest: `after` is not a cursor.
    """
    if after is not None:
        position(after)
    listed = listing(limit, after)
    return {"items": [make(item) for item in listed.items], "next": listed.next}


def position(cursor: str) -> int:
    """Return the number that a cursor stands for.

    Raises:
        InvalidRequest: it is not a cursor.
    """
    if not (cursor.isascii() and cursor.isdigit() and len(cursor) <= _LONGEST_CURSOR):
        raise InvalidRequest(f"after: expected the `next` of a page, got {cursor[:40]!r}")
    return int(cursor)
