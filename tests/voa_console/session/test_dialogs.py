"""Failures of actions as sentences: a database that is busy, and a service that was killed and started again."""

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from queue import Queue
from threading import Thread

import httpx2
import pytest
from playwright.sync_api import Browser, Page, expect

from tests.support.browser import console_of, opened
from tests.support.console_sessions import box_session, look
from tests.support.replicas import Replica, replicas
from tests.support.session_page import SMALL, expect_version, open_page, region
from voa_client import Client, Session
from voa_console.session.dialogs import ChangedMeanwhile, check_version, refusal_sentence


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """An empty page whose scene is small, and drawn fast."""
    with opened(browser, SMALL) as own:
        yield own


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("replica")


@pytest.fixture(scope="module")
def replica(folder: Path) -> Iterator[Replica]:
    """A service that lets one write wait, and refuses further ones."""
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("VOA_SCAN_QUEUE", "1")
        with replicas(f"sqlite:///{folder / 'voa.db'}", folder) as (own,):
            yield own


@pytest.fixture(scope="module")
def own_console(replica: Replica, folder: Path) -> Iterator[str]:
    with console_of(replica.url, folder) as url:
        yield url


@pytest.fixture
def session(replica: Replica, tmp_path: Path) -> Session:
    with Client(replica.url) as client:
        return look(client, box_session(client, tmp_path))


def test_an_older_version_is_refused_before_the_call() -> None:
    check_version(3, 3)
    check_version(3, None)
    with pytest.raises(ChangedMeanwhile) as error:
        check_version(3, 4)
    assert "you saw version 3, and it has version 4 now" in refusal_sentence(error.value, 3, 4)


def test_a_busy_service_is_reported_with_a_sentence_and_the_action_can_be_repeated(
    page: Page, own_console: str, replica: Replica, session: Session, folder: Path, tmp_path: Path
) -> None:
    with Client(replica.url) as client:
        others = [box_session(client, tmp_path).id for _ in range(WRITERS)]
        open_page(page, own_console, session)
        page.get_by_role("button", name="Reset belief").click()
        dialog = page.get_by_role("dialog")
        with locked(folder / "voa.db"), writing(replica.url, others):
            dialog.get_by_role("button", name="Reset belief").click()
            expect(dialog.get_by_role("alert")).to_contain_text(
                "The service is busy at the moment, and changed nothing."
            )
        assert client.get_session(session.id).version == 1
        dialog.get_by_role("button", name="Reset belief").click()
        expect_version(page, 2, 2)
        assert client.get_session(session.id).version == 2


WRITERS = 12
"""Writes at a time that fill the queue of the service, and more."""


@contextmanager
def locked(database: Path) -> Iterator[None]:
    """Lock a database, so that writes wait."""
    with closing(sqlite3.connect(database, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        yield
        other.execute("ROLLBACK")


@contextmanager
def writing(url: str, sessions: Sequence[str]) -> Iterator[None]:
    """Send a write to each session at the same time; goes on when the service refuses the first of them."""
    statuses: Queue[int] = Queue()

    def write(session_id: str) -> None:
        answer = httpx2.put(f"{url}/v1/sessions/{session_id}/belief", json={"belief": None}, timeout=60.0)
        statuses.put(answer.status_code)

    threads = [Thread(target=write, args=(session_id,)) for session_id in sessions]
    for thread in threads:
        thread.start()
    assert statuses.get(timeout=30.0) == 503
    yield
    for thread in threads:
        thread.join()


def test_the_page_survives_a_killed_service(page: Page, own_console: str, replica: Replica, session: Session) -> None:
    open_page(page, own_console, session)
    replica.kill()
    expect(page.get_by_role("alert").get_by_text("This page shows the last state")).to_be_visible()
    expect(region(page, "Grasps").get_by_role("listitem").first).to_be_visible()
    replica.start()
    expect(page.get_by_role("alert").get_by_text("This page shows the last state")).to_be_hidden()
    with Client(replica.url) as client:
        look(client, session, "N")
    expect_version(page, 2, 2)
    expect(region(page, "Last update").get_by_text("Scan from N.")).to_be_visible()
