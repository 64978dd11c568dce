"""The page Now in a real browser, beside a real service that a robot sends scans to over Zenoh."""

import re
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.support.browser import NARROW, console_of, opened, picture
from tests.support.bus import Stranger, stranger
from tests.support.replicas import Replica
from tests.support.routers import router
from tests.support.serving import data_scenario, scan_of
from tests.voa_cli.labs import service_on
from voa_client import Client, OutcomeRequest, ScanRequest, ScenarioRequest, SessionRequest

GOOD = [0.5, 0.5, None, 1.0]
AWAY = re.compile("The service does not respond|did not answer in time")


@dataclass(frozen=True)
class Lab:
    """Service with a console, and a bus on which robots send scans."""

    client: Client
    console: str
    bus: Stranger

    def open_session(self, name: str = "data") -> str:
        scenario = self.client.create_scenario(ScenarioRequest.model_validate(data_scenario(name=name)))
        return self.client.create_session(SessionRequest(scenario=scenario.id)).id

    def apply_scan(self, session: str) -> None:
        self.client.apply_scan(session, ScanRequest.model_validate(scan_of(GOOD)))


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("now")
    with (
        router() as own,
        service_on(own, folder, []) as service,
        Client(service.url) as client,
        console_of(service.url, folder) as console,
        stranger(own.endpoint) as bus,
    ):
        yield Lab(client, console, bus)


def card_of(page: Page, session: str) -> Locator:
    return page.get_by_role("article", name=re.compile(session))


def test_without_sessions_the_page_says_what_to_do_and_a_card_appears_by_itself(page: Page, lab: Lab) -> None:
    for summary in lab.client.list_sessions():
        lab.client.delete_session(summary.id)
    page.goto(lab.console)
    expect(page.get_by_text("No session moved in the last hour. Open one here")).to_be_visible()
    session = lab.open_session()
    expect(card_of(page, session).get_by_text("version 0")).to_be_visible()
    expect(page.get_by_text("No session moved")).to_be_hidden()


def test_a_card_follows_its_session_by_whoever_it_is_changed_and_goes_with_it(
    page: Page, lab: Lab, tmp_path: Path
) -> None:
    session = lab.open_session()
    page.goto(lab.console)
    card = card_of(page, session)
    expect(card.get_by_text("0.33")).to_have_count(3)
    lab.apply_scan(session)
    expect(card.get_by_text("version 1")).to_be_visible()
    expect(card.get_by_text("0.44")).to_be_visible()
    lab.bus.put_scan(session, scan_of(GOOD), robot="tb3_1")
    expect(card.get_by_text("version 2")).to_be_visible()
    expect(card.get_by_text(re.compile(r"tb3_1 at Q1, scan \d"))).to_be_visible()
    picture(page, "now-wide", tmp_path)
    lab.client.delete_session(session)
    expect(card).to_have_count(0)


def test_a_card_turns_red_with_the_reason_while_scans_are_refused(page: Page, lab: Lab, tmp_path: Path) -> None:
    session = lab.open_session()
    page.goto(lab.console)
    card = card_of(page, session)
    expect(card.get_by_text("version 0")).to_be_visible()
    expect(card.get_by_role("alert")).to_have_count(0)
    lab.bus.put_scan(session, {"sensor": "Q1", "scan": {"ranges": []}}, robot="tb3_9")
    expect(card.get_by_role("alert")).to_contain_text("Scans refused")
    expect(card.get_by_role("alert")).to_contain_text("at least 1 item")
    picture(page, "now-refused", tmp_path)


def test_a_session_is_opened_by_mouse(page: Page, lab: Lab) -> None:
    lab.open_session("the one to choose")
    before = {summary.id for summary in lab.client.list_sessions()}
    page.goto(lab.console)
    page.get_by_role("button", name="Open a session").click()
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_label("Scenario")).to_have_value(re.compile("the one to choose"))
    assert {summary.id for summary in lab.client.list_sessions()} == before, "nothing is done before it is confirmed"
    dialog.get_by_role("button", name="Open session").click()
    page.wait_for_url(re.compile("/sessions/"))
    (new,) = [summary for summary in lab.client.list_sessions() if summary.id not in before]
    assert page.url.endswith(new.id)
    assert lab.client.get_scenario(new.scenario).name == "the one to choose"


def test_cards_say_what_happened_and_are_filtered_by_name(page: Page, lab: Lab, tmp_path: Path) -> None:
    others = [lab.open_session("mug") for _ in range(7)]
    mallet = lab.open_session("mallet")
    lab.apply_scan(mallet)
    lab.client.report_outcome(mallet, OutcomeRequest(grasp="G1", success=True))
    page.goto(lab.console)
    expect(page.get_by_text("Sessions that moved in the last hour.")).to_be_visible()
    expect(card_of(page, mallet).get_by_text("Looked once; G1 succeeded")).to_be_visible()
    expect(card_of(page, mallet).get_by_text(mallet, exact=True)).to_be_visible()
    expect(card_of(page, others[0]).get_by_text("Waits for a look")).to_be_visible()
    page.get_by_role("textbox", name="Filter by name").fill("MALL")
    expect(page.get_by_role("article")).to_have_count(1)
    picture(page, "now-filtered", tmp_path)
    page.get_by_role("textbox", name="Filter by name").fill("teapot")
    expect(page.get_by_text("No session that moved in the last hour has “teapot” in its name.")).to_be_visible()


def test_the_page_of_a_session_belongs_to_now(page: Page, lab: Lab) -> None:
    page.goto(f"{lab.console}/sessions/{lab.open_session()}")
    expect(page.get_by_role("link", name="Now", exact=True)).to_have_attribute("aria-current", "true")
    page.get_by_text(re.compile("^service: http")).hover()
    expect(page.get_by_text("the service that this console watches")).to_be_visible()


def test_every_action_can_be_reached_by_keyboard(page: Page, lab: Lab) -> None:
    session = lab.open_session()
    page.goto(lab.console)
    expect(card_of(page, session)).to_be_visible()
    reached = []
    for _ in range(8):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.ariaLabel || document.activeElement.innerText"))
    for name in ("Now", "New object", "Robots", "Dark or light"):
        assert name in reached
    assert any("Open a session" in name for name in reached)
    assert any(session in name for name in reached)


def test_the_page_fits_a_telephone_in_the_dark(browser: Browser, lab: Lab, tmp_path: Path) -> None:
    session = lab.open_session()
    with opened(browser, NARROW, dark=True) as page:
        page.goto(lab.console)
        expect(card_of(page, session)).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= NARROW[0]
        assert page.evaluate("document.body.classList.contains('body--dark')")
        picture(page, "now-narrow-dark", tmp_path)
        page.get_by_role("button", name="Dark or light").click()
        expect(page.locator("body.body--light")).to_be_visible()
        page.reload()
        expect(page.locator("body.body--light")).to_be_visible()


NOTE_TIMES = """session => {
    const card = document.querySelector(`[aria-label="Session ${session}"]`);
    window.times = {};
    new MutationObserver(() => {
        const version = card.innerText.match(/version (\\d+)/)[1];
        window.times[version] ??= Date.now();
    }).observe(card, {subtree: true, childList: true, characterData: true});
}"""


def test_a_commit_is_shown_by_the_service_s_event_and_not_by_the_next_poll(page: Page, lab: Lab) -> None:
    """Median of eleven commits: within 300 ms, where a poll once per second would need 500."""
    session = lab.open_session()
    page.goto(lab.console)
    card = card_of(page, session)
    expect(card.get_by_text("version 0")).to_be_visible()
    page.evaluate(NOTE_TIMES, session)
    committed = []
    for version in range(1, 12):
        lab.apply_scan(session)
        committed.append(time.time())
        expect(card.get_by_text(f"version {version},")).to_be_visible()
    shown = page.evaluate("window.times")
    delays = [shown[str(version)] / 1000.0 - committed[version - 1] for version in range(1, 12)]
    assert statistics.median(delays) < 0.3, delays


def test_pages_survive_a_service_that_is_killed_and_restarted(page: Page, tmp_path: Path) -> None:
    replica = Replica(f"sqlite:///{tmp_path / 'voa.db'}", tmp_path / "service.log")
    try:
        replica.start()
        with Client(replica.url) as client, console_of(replica.url, tmp_path) as console:
            scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
            session = client.create_session(SessionRequest(scenario=scenario.id)).id
            page.goto(console)
            card = card_of(page, session)
            expect(card.get_by_text("version 0")).to_be_visible()
            replica.kill()
            expect(page.get_by_text(AWAY)).to_be_visible()
            expect(card.get_by_text("version 0")).to_be_visible()
            picture(page, "now-service-away", tmp_path)
            replica.start()
            client.apply_scan(session, ScanRequest.model_validate(scan_of(GOOD)))
            expect(card.get_by_text("version 1")).to_be_visible()
            expect(page.get_by_text(AWAY)).to_be_hidden()
    finally:
        replica.end()


def test_pages_of_a_console_on_zenoh_survive_a_router_that_is_killed_and_restarted(page: Page, tmp_path: Path) -> None:
    with (
        router() as own,
        service_on(own, tmp_path, []) as service,
        Client(service.url) as client,
        console_of(service.zenoh, tmp_path) as console,
    ):
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        page.goto(console)
        card = card_of(page, session)
        expect(card.get_by_text("version 0")).to_be_visible()
        own.kill()
        expect(page.get_by_text(AWAY)).to_be_visible()
        own.start()
        client.apply_scan(session, ScanRequest.model_validate(scan_of(GOOD)))
        expect(card.get_by_text("version 1")).to_be_visible()
        expect(page.get_by_text(AWAY)).to_be_hidden()


def test_a_page_says_that_its_console_is_gone(page: Page, process: str, tmp_path: Path) -> None:
    with console_of(process, tmp_path) as console:
        page.goto(console)
        expect(page.get_by_role("heading", name="Now")).to_be_visible()
    expect(page.get_by_text("Connection lost")).to_be_visible()


HOSTILE = """a" :title="document.title='taken over'" <img src=x onerror="document.title='taken over'"> C:\\x '\\n"""
"""Name that would become a property of its own, an element, or an escape, if a page parsed it."""


def test_names_are_shown_as_they_are_whatever_they_contain(page: Page, lab: Lab) -> None:
    changes = {"name": HOSTILE, "grasps": [{"name": HOSTILE}, {"name": "G2"}]}
    scenario = lab.client.create_scenario(ScenarioRequest.model_validate(data_scenario(**changes)))
    session = lab.client.create_session(SessionRequest(scenario=scenario.id)).id
    page.goto(lab.console)
    expect(card_of(page, session).get_by_role("link").first).to_have_text(HOSTILE)
    page.goto(f"{lab.console}/sessions/{session}")
    expect(page.get_by_role("region", name="Grasps").get_by_role("listitem").first).to_have_accessible_name(
        re.compile(re.escape(HOSTILE[:20]))
    )
    expect(page).not_to_have_title(re.compile("taken over"))
    lab.client.delete_session(session)
