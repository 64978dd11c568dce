"""The page Robots in a real browser: a robot on a real router, its mistakes, and their repair."""

import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.support.browser import NARROW, console_of, opened, picture
from tests.support.routers import router
from tests.voa_console.robots.worlds import ROBOT, Laboratory, laboratory
from voa_client import SessionRequest, ZenohAddress
from voa_client.zenoh_session import joined
from voa_msgs.keys import Keys
from voa_ros.motions import Motion

SLOW_MS = 20_000.0
"""Time limit for what needs several requests of the console, on a busy machine, milliseconds."""


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Laboratory]:
    with router() as bus, laboratory(bus, tmp_path_factory.mktemp("lab")) as running:
        yield running


@pytest.fixture(scope="module")
def robots(own: Laboratory, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with console_of(own.lab.url, tmp_path_factory.mktemp("console")) as url:
        yield f"{url}/robots"


@contextmanager
def mapped(own: Laboratory, more: str = "") -> Iterator[str]:
    """Map the robot, and open a session for it; yields its id."""
    own.map(more)
    session = own.client.create_session(SessionRequest(scenario=own.scenario, robots=[ROBOT])).id
    try:
        yield session
    finally:
        own.client.delete_session(session)
        own.mapping.write_text("")
        own.robot.is_mirrored = own.robot.is_contradictory = False


def section(page: Page) -> Locator:
    return page.get_by_role("region", name=f"Robot {ROBOT}")


def chart(page: Page, reading: str, more: str = "") -> Locator:
    shown = rf"Scan of {ROBOT} from above, {reading}: \d\d+ returns in the workspace, {more}"
    return section(page).get_by_role("img", name=re.compile(shown))


def test_a_robot_in_order_is_shown_over_the_prediction(
    page: Page, own: Laboratory, robots: str, tmp_path: Path
) -> None:
    with mapped(own) as session:
        page.goto(robots)
        expect(page.get_by_role("heading", name="Robots", exact=True)).to_be_visible()
        expect(chart(page, "as measured", "over a prediction")).to_be_visible(timeout=SLOW_MS)
        expect(section(page).get_by_text(f"{ROBOT} at E, scan 0.")).to_be_visible(timeout=SLOW_MS)
        expect(section(page).get_by_text("x 0.400 m, y 0.050 m (± 0.5 cm)")).to_be_visible()
        expect(section(page).get_by_role("link")).to_have_attribute("href", f"/sessions/{session}")
        expect(section(page).get_by_role("alert")).to_be_hidden()
        page.get_by_role("button", name="8 checks passed").click()
        service = page.get_by_role("list", name="Checks of the service that passed")
        expect(service.get_by_text("connection: 127.0.0.1:")).to_be_visible()
        picture(page, "robots-wide", tmp_path)


def test_a_mirrored_lidar_is_named_shown_and_repaired(page: Page, own: Laboratory, robots: str, tmp_path: Path) -> None:
    own.robot.is_mirrored = True
    with mapped(own):
        page.goto(robots)
        alert = section(page).get_by_role("alert")
        expect(alert.get_by_text("scan-mirrored")).to_be_visible(timeout=SLOW_MS)
        expect(alert.get_by_text("lidar = { upside_down = true }")).to_be_visible()
        section(page).get_by_role("button", name="Mirrored").click()
        expect(chart(page, "mirrored", "over a prediction")).to_be_visible(timeout=SLOW_MS)
        expect(section(page).get_by_role("button", name="Mirrored", pressed=True)).to_be_visible()
        picture(page, "robots-mirrored", tmp_path)
        own.map("lidar = { upside_down = true }")
        page.get_by_role("button", name="Examine now").click()
        fits = section(page).get_by_role("button", name=re.compile(r"^As measured: \d\.\d mm$"))
        expect(fits).to_be_visible(timeout=SLOW_MS)
        expect(alert).to_be_hidden()


def test_a_turned_lidar_is_named_with_the_line_that_repairs_it(page: Page, own: Laboratory, robots: str) -> None:
    with mapped(own, "lidar = { yaw_rad = 1.5708 }"):
        page.goto(robots)
        alert = section(page).get_by_role("alert")
        expect(alert.get_by_text("scan-turned")).to_be_visible(timeout=SLOW_MS)
        expect(alert.get_by_text("lidar = { yaw_rad = -1.5708 }")).to_be_visible()
        section(page).get_by_role("button", name="Turned by 270°").click()
        expect(chart(page, "turned by 270°", "over a prediction")).to_be_visible(timeout=SLOW_MS)


def test_refusals_are_listed_with_their_times(page: Page, own: Laboratory, robots: str, tmp_path: Path) -> None:
    own.robot.is_contradictory = True
    with mapped(own):
        page.goto(robots)
        refusals = section(page).get_by_role("list", name=f"Last refusals of {ROBOT}")
        expect(refusals.get_by_text("angle_increment")).to_be_visible(timeout=SLOW_MS)
        expect(refusals.get_by_text(re.compile(r"s ago, \d+ times"))).to_be_visible()
        checks = section(page).get_by_role("list", name=f"Checks of {ROBOT}")
        expect(checks.get_by_role("img", name="wrong")).to_be_visible()
        expect(checks.get_by_text("→ Correct the driver's settings")).to_be_visible()
        picture(page, "robots-refused", tmp_path)


def test_a_robot_that_puts_its_scans_is_shown_too(page: Page, own: Laboratory, robots: str) -> None:
    with mapped(own) as session, joined(ZenohAddress.parse(own.lab.endpoint)) as bus:
        ranges = own.robot.bench.ranges(Motion(0.0, 0.4, -math.pi / 2), "as made").tolist()
        body = {"sensor": "N", "scan": {"ranges": ranges}}
        bus.put(Keys().scan(session, "putter"), json.dumps(body), encoding="application/json")
        page.goto(robots)
        putter = page.get_by_role("region", name="Robot putter")
        expect(putter.get_by_text("putter at N")).to_be_visible(timeout=SLOW_MS)
        shown = re.compile(r"Scan of putter from above, as measured: \d\d+ returns in the workspace, over a prediction")
        expect(putter.get_by_role("img", name=shown)).to_be_visible(timeout=SLOW_MS)


def test_the_page_fits_a_telephone_in_the_dark(browser: Browser, own: Laboratory, robots: str, tmp_path: Path) -> None:
    own.robot.is_mirrored = True
    with mapped(own), opened(browser, NARROW, dark=True) as page:
        page.goto(robots)
        expect(section(page).get_by_role("alert")).to_be_visible(timeout=SLOW_MS)
        assert page.evaluate("document.documentElement.scrollWidth") <= NARROW[0]
        picture(page, "robots-narrow-dark", tmp_path)
        section(page).get_by_role("alert").scroll_into_view_if_needed()
        picture(page, "robots-narrow-dark-scan", tmp_path)


def test_without_robots_the_page_says_how_to_map_one(page: Page, console: str) -> None:
    page.goto(f"{console}/robots")
    expect(page.get_by_role("region", name="No robots").get_by_text("--robots robots.toml")).to_be_visible(
        timeout=SLOW_MS
    )
