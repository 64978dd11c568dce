"""Keys in real browsers, beside a real service that needs them: entered, obeyed, revoked and forgotten."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.support.api_keys import bearer, make_key, revoke_key, url_of
from tests.support.browser import NARROW, console_of, opened, picture
from tests.support.replicas import Replica
from tests.support.serving import data_scenario
from tests.support.session_page import SMALL
from tests.support.waiting import wait_for
from voa_client import Client, ScenarioRequest, SessionRequest
from voa_client.local import local_service
from voa_msgs.callers import Role

ROLES: tuple[Role, ...] = ("viewer", "arm", "operator")


@dataclass(frozen=True)
class Lab:
    """Service that needs keys, with a session, a key of each role, and a console without a key of its own."""

    database: str
    console: str
    session: str
    keys: dict[Role, str]
    elsewhere: str
    """Key of an operator for another session."""


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("keys")
    with local_service(folder) as service, console_of(service, folder) as console:
        with Client(service) as client:
            scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
            session = client.create_session(SessionRequest(scenario=scenario.id)).id
        database = url_of(folder / "voa.db")
        elsewhere = make_key(database, "operator", "elsewhere", sessions=("another",))
        keys = {role: make_key(database, role) for role in ROLES}
        newest = bearer(keys[ROLES[-1]])
        wait_for(lambda: httpx2.get(f"{service}/v1/caller", headers=newest).json().get("key"), "the keys")
        yield Lab(database, console, session, keys, elsewhere)


@pytest.fixture
def viewer(lab: Lab) -> str:
    return lab.keys["viewer"]


def enter(page: Page, key: str) -> None:
    """Send the form with a key."""
    expect(page.get_by_role("heading", name="Enter your key")).to_be_visible()
    page.get_by_label("Key", exact=True).fill(key)
    page.get_by_role("button", name="Open the console").click()


def actions(page: Page) -> Locator:
    """Buttons of the page of a session."""
    return page.get_by_role("toolbar", name="Actions").get_by_role("button")


def test_a_viewer_enters_a_key_sees_a_session_without_actions_and_leaves_when_the_key_is_revoked(
    browser: Browser, lab: Lab, viewer: str, tmp_path: Path
) -> None:
    with opened(browser, NARROW, dark=True) as page:
        page.goto(f"{lab.console}/sessions/{lab.session}")
        expect(page.get_by_role("alert")).to_have_count(0)
        picture(page, "key-narrow-dark", tmp_path)
        enter(page, "voa_000000000000_" + "0" * 64)
        expect(page.get_by_role("alert")).to_contain_text("The service does not accept the key")
        enter(page, viewer)
        page.wait_for_url(f"{lab.console}/sessions/{lab.session}")
        expect(actions(page)).to_have_text([re.compile("Export")])
        expect(page.get_by_text("The key viewer-1 (viewer) allows no other action.")).to_be_visible()
        expect(page.get_by_role("group", name="Key")).to_contain_text("viewer-1, viewer")
        expect(page.get_by_role("link", name="New object")).to_have_count(0)
        assert page.evaluate("document.documentElement.scrollWidth") <= NARROW[0]
        assert page.evaluate("document.cookie") == "", "no script reads the secret"
        assert viewer not in page.content()
        picture(page, "viewer-narrow-dark", tmp_path)
        page.goto(f"{lab.console}/new")
        expect(page.get_by_text("Making an object needs a key with the role operator.")).to_be_visible()
        page.goto(lab.console)
        expect(page.get_by_role("article")).to_have_count(1)
        expect(page.get_by_role("button", name="Open a session")).to_have_count(0)
        revoke_key(lab.database, viewer)
        expect(page.get_by_role("alert")).to_contain_text(re.compile("the key 'viewer-1' .* was revoked"))
        expect(page.get_by_role("heading", name="Enter your key")).to_be_visible()


def test_browsers_with_other_keys_see_other_actions_and_all_pages_leave_when_a_key_is_forgotten(
    browser: Browser, lab: Lab
) -> None:
    with opened(browser, SMALL) as page, opened(browser, SMALL) as other:
        for each, key in ((page, lab.keys["arm"]), (other, lab.keys["operator"])):
            each.goto(f"{lab.console}/sessions/{lab.session}")
            enter(each, key)
        expect(actions(page)).to_have_text([re.compile("Report an outcome"), re.compile("Export")])
        expect(actions(other)).to_have_count(8)
        page.get_by_role("button", name="Report an outcome").click()
        page.get_by_role("dialog").get_by_role("button", name="Report outcome").click()
        expect(page.get_by_text("version 1 of 1, now").first).to_be_visible()
        expect(other.get_by_text("version 1 of 1, now").first).to_be_visible()
        second = page.context.new_page()
        second.goto(lab.console)
        expect(second.get_by_role("group", name="Key")).to_contain_text("arm-1, arm")
        second.get_by_role("button", name="Forget the key").click()
        for each in (second, page):
            expect(each.get_by_role("heading", name="Enter your key")).to_be_visible()
        expect(second.get_by_role("alert")).to_have_text(re.compile("The key is forgotten."))
        page.goto(f"{lab.console}/sessions/{lab.session}")
        enter(page, lab.elsewhere)
        expect(page.get_by_text(f"The key elsewhere is not for session {lab.session}.")).to_be_visible()
        expect(actions(page)).to_have_count(0)
        expect(actions(other)).to_have_count(8)


def test_the_page_says_that_the_service_does_not_respond_and_leads_on_once_it_has_no_keys(
    page: Page, tmp_path: Path
) -> None:
    replica = Replica(f"sqlite:///{tmp_path / 'voa.db'}", tmp_path / "service.log")
    try:
        replica.start()
        replica.kill()
        with console_of(replica.url, tmp_path) as console:
            page.goto(console)
            expect(page.get_by_text("This page continues by itself.")).to_have_count(1)
            expect(page.get_by_role("alert")).to_have_count(0)
            replica.start()
            expect(page.get_by_role("heading", name="Now")).to_be_visible(timeout=30_000)
    finally:
        replica.end()


def test_no_page_and_no_log_has_what_a_key_is_needed_for(lab: Lab, viewer: str) -> None:
    for path in ("/", "/new", "/robots", f"/sessions/{lab.session}", "/new/files/0a/rest-1.png", "/meshes/a.stl"):
        answer = httpx2.get(f"{lab.console}{path}", timeout=30.0)
        assert answer.status_code in (303, 401), path
        assert lab.session not in answer.text
    log = (Path(lab.database.removeprefix("sqlite:///")).parent / "console.log").read_text()
    assert viewer.rpartition("_")[2] not in log
    assert "Traceback" not in log
