"""Actions of the page of a session: by mouse in a real browser, their effect read back by another client."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import opened
from tests.support.console_sessions import box_session, look
from tests.support.session_page import SMALL, expect_version, open_page, region
from tests.support.waiting import wait_for
from voa_client import Client, NotFoundError, Session
from voa_recordings.session_file import read_session_file, rebuild_session


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """An empty page whose scene is small, and drawn fast."""
    with opened(browser, SMALL) as own:
        yield own


@pytest.fixture
def robot(process: str) -> Iterator[Client]:
    """Client of the service beside the console."""
    with Client(process) as client:
        yield client


@pytest.fixture
def session(robot: Client, tmp_path: Path) -> Session:
    """A session with one look."""
    return look(robot, box_session(robot, tmp_path))


def confirm(page: Page, action: str, button: str) -> None:
    """Open the dialog of an action and confirm it."""
    page.get_by_role("button", name=action, exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name=button).click()


def test_an_outcome_is_reported(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="Report an outcome").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Grasp").click()
    page.get_by_role("option", name="G2").click()
    dialog.get_by_role("radio", name="failed").click()
    dialog.get_by_label("Probability that the object was moved").fill("0.25")
    dialog.get_by_role("button", name="Report outcome").click()
    expect_version(page, 2, 2)
    expect(dialog).to_have_count(0)
    newest = list(robot.history(session.id))[-1]
    assert (newest.version, newest.kind) == (2, "outcome")
    assert newest.request == {"grasp": "G2", "success": False, "object_moved": 0.25}


def test_the_belief_is_reset(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    confirm(page, "Reset belief", "Reset belief")
    wait_for(lambda: robot.get_session(session.id).version == 2, "the belief is reset")
    assert robot.get_session(session.id).belief == [0.5, 0.5]


def test_a_look_is_announced(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="Announce a look").click()
    page.get_by_role("dialog").get_by_label("Place").click()
    page.get_by_role("option", name="N", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Announce look").click()
    wait_for(lambda: robot.get_session(session.id).under_way, "the look is announced")
    assert [each.sensor for each in robot.get_session(session.id).under_way] == ["N"]


def test_another_session_is_opened(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    before = {each.id for each in robot.list_sessions()}
    confirm(page, "Open another session", "Open session")
    page.wait_for_url(re.compile(f"/sessions/(?!{session.id})"))
    (new,) = {each.id for each in robot.list_sessions()} - before
    assert page.url.endswith(new)
    assert robot.get_session(new).scenario == session.scenario
    expect_version(page, 0, 0)


def test_a_session_is_ended(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    confirm(page, "End session", "End session")
    expect(page.get_by_text("This session has ended, or never existed.")).to_be_visible()
    with pytest.raises(NotFoundError):
        robot.get_session(session.id)


def test_a_session_is_exported_so_that_it_can_be_rebuilt(
    page: Page, console: str, session: Session, robot: Client, tmp_path: Path
) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="Export").click()
    with page.expect_download() as download:
        page.get_by_role("dialog").get_by_role("button", name="Download file").click()
    path = tmp_path / "session.json"
    download.value.save_as(path)
    assert download.value.suggested_filename == f"session-{session.id}.json"
    assert len(json.loads(path.read_text())["history"]) == 2
    assert rebuild_session(robot, read_session_file(path)).same


def test_nothing_happens_before_the_confirmation(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="End session").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert robot.get_session(session.id).version == 1


def test_who_saw_an_older_version_is_refused_with_a_sentence(
    page: Page, console: str, session: Session, robot: Client
) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="Report an outcome").click()
    look(robot, session, "N")
    expect_version(page, 2, 2)
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Report outcome").click()
    alert = dialog.get_by_role("alert")
    expect(alert).to_contain_text("Somebody else changed the session in the meantime (it has version 2 now)")
    assert robot.get_session(session.id).version == 2
    dialog.get_by_role("button", name="Cancel").click()
    expect(region(page, "Last update").get_by_text("Scan from N.")).to_be_visible()


def test_an_announcement_for_an_older_version_is_refused_with_a_sentence(
    page: Page, console: str, session: Session, robot: Client
) -> None:
    open_page(page, console, session)
    page.get_by_role("button", name="Announce a look").click()
    look(robot, session, "N")
    expect_version(page, 2, 2)
    page.get_by_role("dialog").get_by_role("button", name="Announce look").click()
    expect(page.get_by_role("dialog").get_by_role("alert")).to_contain_text(
        "you saw version 1, and it has version 2 now"
    )
    assert robot.get_session(session.id).under_way == []
