"""Pages of lists: items and the cursor of the next page; a cursor that is none is refused."""

import pytest

from voa_service.failures import InvalidRequest
from voa_service.usecases.pages import page, position
from voa_store.records import Listed


def test_a_page_converts_its_items_and_hands_on_the_cursor() -> None:
    calls: list[tuple[int, str | None]] = []

    def listing(limit: int, after: str | None) -> Listed[int]:
        calls.append((limit, after))
        return Listed([1, 2], "2")

    assert page(listing, str, 2, "0") == {"items": ["1", "2"], "next": "2"}
    assert calls == [(2, "0")]


def test_a_cursor_is_a_number_of_at_most_18_digits() -> None:
    assert [position("0"), position("9" * 18)] == [0, 10**18 - 1]


@pytest.mark.parametrize("cursor", ["", "-1", "1.5", "abc", "9" * 19, "\u0662"])
def test_any_other_cursor_is_refused_before_the_store_is_read(cursor: str) -> None:
    def listing(limit: int, after: str | None) -> Listed[int]:
        raise AssertionError("the store was read")

    with pytest.raises(InvalidRequest, match=r"^after: expected the `next` of a page"):
        page(listing, str, 1, cursor)
