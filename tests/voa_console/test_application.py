"""A running console refuses foreign names and pages of other sites, and every page is linked from every other."""

import httpx2
import pytest
from playwright.sync_api import Page, expect

SECONDS = 30.0


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Host": "localhost:1"}, 200),
        ({"Host": "evil.example"}, 400),
        ({"Host": "127.0.0.1.evil.example"}, 400),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
    ],
)
def test_only_its_own_pages_reach_it(console: str, headers: dict[str, str], status: int) -> None:
    for path in ("/", "/livez"):
        assert httpx2.get(f"{console}{path}", headers=headers, timeout=SECONDS).status_code == status


def test_a_page_of_another_site_cannot_open_the_events_of_a_page(console: str) -> None:
    handshake = f"{console}/_nicegui_ws/socket.io/?EIO=4&transport=polling"
    assert httpx2.get(handshake, timeout=SECONDS).status_code != 403
    assert httpx2.get(handshake, headers={"Origin": "http://evil.example"}, timeout=SECONDS).status_code == 403


def test_the_pages_are_linked(page: Page, console: str) -> None:
    page.goto(console)
    for name in ("New object", "Robots", "Now"):
        page.get_by_role("navigation", name="Pages").get_by_role("link", name=name).click()
        expect(page.get_by_role("heading", name=name, exact=True, level=1)).to_be_visible()
        current = page.get_by_role("navigation", name="Pages").locator('[aria-current="page"]')
        expect(current).to_have_text(name)
