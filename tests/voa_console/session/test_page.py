"""The page of a session in a real browser, beside a real service and a robot that writes to the same session."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import NARROW, WIDE, opened, picture
from tests.support.console_sessions import box_session, look
from tests.support.session_page import (
    expect_version,
    look_from_above,
    on_screen,
    open_page,
    region,
    shapes,
    wait_for_shape,
)
from voa_client import Client, Session


@pytest.fixture
def robot(process: str) -> Iterator[Client]:
    """Client of the service beside the console."""
    with Client(process) as client:
        yield client


@pytest.fixture
def session(robot: Client, tmp_path: Path) -> Session:
    return box_session(robot, tmp_path)


def test_the_scene_has_the_object_the_places_and_the_grasp(page: Page, console: str, session: Session) -> None:
    open_page(page, console, session)
    wait_for_shape(page, "belief/B")
    assert {"belief/A", "belief/B", "looks/E", "looks/N", "table/table"} <= set(shapes(page))


def test_a_scan_of_a_robot_is_shown_within_a_moment(
    page: Page, console: str, session: Session, robot: Client, tmp_path: Path
) -> None:
    open_page(page, console, session)
    expect_version(page, 0, 0)
    after = look(robot, session)
    expect_version(page, 1, 1)
    expect(region(page, "Last update").get_by_text("Scan from E. Best fit: A")).to_be_visible()
    best = region(page, "Grasps").get_by_role("listitem").first
    expect(best).to_have_accessible_name(f"{after.best_grasp} {after.expected_score:.3f}")
    wait_for_shape(page, "scan/return")
    picture(page, "session-wide", tmp_path)


def test_the_time_line_shows_the_past_and_comes_back_to_now(
    page: Page, console: str, session: Session, robot: Client, tmp_path: Path
) -> None:
    look(robot, session)
    after = look(robot, session, "N")
    open_page(page, console, session)
    slider = page.get_by_role("slider", name="Version that is shown")
    expect(slider).to_have_attribute("aria-valuenow", "2")
    slider.scroll_into_view_if_needed()
    track = slider.bounding_box()
    assert track is not None
    page.mouse.click(track["x"] + 2, track["y"] + track["height"] / 2)
    expect_version(page, 0, 2, "the past")
    expect(region(page, "Last update").get_by_text("The session was opened")).to_be_visible()
    expect(region(page, "Advice").get_by_text("Version 0 of 2, the past.")).to_be_visible()
    expect(region(page, "Advice").get_by_text("Then came: scan from E.")).to_be_visible()
    expect(page.get_by_role("button", name="Reset belief")).to_be_disabled()
    expect(region(page, "Grasps").get_by_role("listitem").first).to_have_accessible_name("G1 0.500")
    picture(page, "session-past", tmp_path)
    expect(page.get_by_role("status").get_by_text("You see version 0 of 2, the past.")).to_be_visible()
    slider.locator("[tabindex]").focus()
    page.keyboard.press("ArrowRight")
    expect_version(page, 1, 2, "the past")
    happened = region(page, "What happened")
    happened.get_by_role("button", name=re.compile(r"^0\s+Session opened")).click()
    expect_version(page, 0, 2, "the past")
    happened.get_by_role("button", name=re.compile(r"^2\s+Scan from N")).click()
    expect_version(page, 2, 2)
    happened.get_by_role("button", name=re.compile(r"^1\s+Scan from E")).click()
    expect_version(page, 1, 2, "the past")
    page.get_by_role("button", name="Back to now").click()
    expect_version(page, 2, 2)
    name = f"{after.best_grasp} {after.expected_score:.3f}"
    expect(region(page, "Grasps").get_by_role("listitem").first).to_have_accessible_name(name)


def test_a_person_in_the_past_stays_there_while_a_robot_goes_on(
    page: Page, console: str, session: Session, robot: Client
) -> None:
    look(robot, session)
    open_page(page, console, session)
    slider = page.get_by_role("slider", name="Version that is shown")
    expect(slider).to_have_attribute("aria-valuenow", "1")
    slider.locator("[tabindex]").focus()
    page.keyboard.press("ArrowLeft")
    expect_version(page, 0, 1, "the past")
    look(robot, session, "N")
    expect_version(page, 0, 2, "the past")
    expect(slider).to_have_attribute("aria-valuenow", "0")


def test_a_look_from_a_place_of_ones_own_is_valued(page: Page, console: str, session: Session, robot: Client) -> None:
    open_page(page, console, session)
    panel = region(page, "If I looked from here")
    panel.get_by_label("x, m").fill("0.25")
    panel.get_by_label("y, m").fill("0.25")
    panel.get_by_role("button", name="Face the object").click()
    expect(panel.get_by_label("yaw, °")).to_have_value("-135")
    panel.get_by_role("button", name="Value this look").click()
    expect(panel.get_by_text(re.compile(r"From x 0.25 m, y 0.25 m, yaw -135°: VOA "))).to_be_visible()
    wait_for_shape(page, "looks/your place")
    look(robot, session)
    expect(panel.get_by_text("The session moved on")).to_be_visible()


def test_a_dragged_tower_is_valued_where_it_is_dropped(page: Page, console: str, session: Session) -> None:
    open_page(page, console, session)
    look_from_above(page)
    x, y = on_screen(page, "looks/E")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y + 60, steps=8)
    page.mouse.up()
    panel = region(page, "If I looked from here")
    expect(panel.get_by_text(re.compile(r"^From x 0\.\d+ m, y -0\.\d+ m, yaw 1\d\d°: VOA "))).to_be_visible()


def test_pointing_at_a_tower_shows_its_name_and_figure(page: Page, console: str, session: Session) -> None:
    open_page(page, console, session)
    look_from_above(page)
    page.mouse.move(*on_screen(page, "looks/E"))
    expect(region(page, "Scene").get_by_text(re.compile(r"^E: VOA \+0\.\d+"))).to_be_visible()


def test_the_map_of_the_voa_fills_and_can_be_removed(
    page: Page, console: str, session: Session, tmp_path: Path
) -> None:
    open_page(page, console, session)
    panel = region(page, "Map of the Value of Assistance")
    panel.get_by_role("button", name="Map the VOA").click()
    expect(panel.get_by_text(re.compile(r"^(\d+) of \1 places valued\.$"))).to_be_visible()
    tiles = [name for name in shapes(page) if name.startswith("looks/map tile")]
    assert len(tiles) > 100
    picture(page, "session-map", tmp_path)
    panel.get_by_role("button", name="Remove map").click()
    wait_for_shape(page, "looks/map", gone=True)


def test_the_page_fits_a_telephone_in_the_dark(
    browser: Browser, console: str, session: Session, robot: Client, tmp_path: Path
) -> None:
    look(robot, session)
    with opened(browser, NARROW, dark=True) as page:
        open_page(page, console, session)
        assert page.evaluate("document.documentElement.scrollWidth") <= NARROW[0]
        picture(page, "session-narrow-dark", tmp_path)


def test_two_browsers_and_a_robot_see_the_same_session(
    browser: Browser, console: str, session: Session, robot: Client
) -> None:
    with opened(browser, WIDE) as one, opened(browser, NARROW) as other:
        for page in (one, other):
            open_page(page, console, session)
        look(robot, session)
        for page in (one, other):
            expect_version(page, 1, 1)
        one.get_by_role("button", name="Reset belief").click()
        one.get_by_role("dialog").get_by_role("button", name="Reset belief").click()
        for page in (one, other):
            expect_version(page, 2, 2)
            expect(region(page, "Last update").get_by_text("The belief was reset to the prior.")).to_be_visible()
        assert robot.get_session(session.id).version == 2


def test_an_unknown_session_is_said_to_be_unknown(page: Page, console: str) -> None:
    page.goto(f"{console}/sessions/none")
    expect(page.get_by_text("This session has ended, or never existed.")).to_be_visible()
    expect(page.get_by_role("button", name="End session")).to_be_disabled()
