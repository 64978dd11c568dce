"""Actions with mapped robots: by mouse in a real browser, beside a real service with a router."""

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import console_of, opened
from tests.support.routers import router
from tests.support.serving import data_scenario
from tests.support.session_page import SMALL, expect_version, open_page, region
from tests.support.waiting import wait_for
from tests.voa_cli.labs import service_on
from tests.voa_doctor.publishing import publishing, scan, sent
from voa_client import Client, RobotReport, ScenarioRequest, Session, SessionRequest

MAPPING = """
[[robot]]
name = "tb3_1"
scenario = "{scenario}"
place = {{ from = "sensor", sensor = "Q1" }}
look = {{ mode = "on_request", scans = 2 }}
"""


@dataclass(frozen=True)
class Lab:
    """Service with a mapped robot that scans without a pause, and a console of it."""

    client: Client
    console: str
    scenario: str

    def open(self, scenario: str | None = None, *robots: str) -> Session:
        return self.client.create_session(
            SessionRequest(scenario=scenario or self.scenario, robots=list(robots) or None)
        )

    def report(self) -> RobotReport:
        return next(each for each in self.client.robots().items if each.robot == "tb3_1")


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """An empty page whose scene is small, and drawn fast."""
    with opened(browser, SMALL) as own:
        yield own


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("lab")
    mapping = folder / "robots.toml"
    mapping.write_text("")
    seen = sent(
        "tb3_1/scan",
        lambda step: scan(step, ranges=(0.5, 0.5, 1.0, 1.0), angle_increment=0.1, angle_max=0.3, range_max=2.0),
    )
    with (
        router() as own,
        service_on(own, folder, ["--robots", str(mapping)]) as service,
        Client(service.url) as client,
        console_of(service.url, folder) as console,
        publishing(own, seen),
    ):
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario())).id
        mapping.write_text(MAPPING.format(scenario=scenario))
        wait_for(lambda: any(each.robot == "tb3_1" and each.scans for each in client.robots().items), "the robot scans")
        yield Lab(client, console, scenario)


def test_a_robot_is_claimed(page: Page, lab: Lab) -> None:
    lab.open(None, "tb3_1")
    session = lab.open()
    open_page(page, lab.console, session)
    page.get_by_role("button", name="Claim a robot").click()
    page.get_by_role("dialog").get_by_role("button", name="Claim robot").click()
    wait_for(lambda: lab.report().session == session.id, "the robot is claimed")


def test_a_look_is_requested_of_a_robot(page: Page, lab: Lab) -> None:
    session = lab.open(None, "tb3_1")
    open_page(page, lab.console, session)
    wait_for(lambda: lab.report().session == session.id, "the robot belongs to the session")
    request_look(page)
    expect_version(page, 1, 1)
    assert lab.client.get_session(session.id).version == 1
    expect(region(page, "Last update").get_by_text("Scan from Q1.")).to_be_visible()


def request_look(page: Page) -> None:
    """Open the dialog until the console knows the robot of the session, and confirm it."""
    dialog = page.get_by_role("dialog")

    def knows_the_robot() -> bool:
        page.get_by_role("button", name="Request a look").click()
        expect(dialog.get_by_role("button", name="Request look")).to_be_visible()
        if dialog.get_by_role("button", name="Request look").is_enabled():
            return True
        dialog.get_by_role("button", name="Cancel").click()
        expect(dialog).to_have_count(0)
        return False

    wait_for(knows_the_robot, "the console knows the robot of the session")
    dialog.get_by_role("button", name="Request look").click()


def test_a_claim_that_contradicts_the_mapping_is_refused_with_a_sentence(page: Page, lab: Lab) -> None:
    other = lab.client.create_scenario(ScenarioRequest.model_validate(data_scenario(name="other"))).id
    session = lab.open(other)
    open_page(page, lab.console, session)
    page.get_by_role("button", name="Claim a robot").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Claim robot").click()
    expect(dialog.get_by_role("alert")).to_contain_text("This contradicts the present state")
    assert lab.report().session != session.id
