"""Each key has a console of its own, which shows what that key may see, for as long as the service accepts it."""

import asyncio
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.support.api_keys import key_for, make_key, revoke_key, url_of
from tests.support.serving import Service, serving
from tests.voa_console.keys.doors import NONSENSE, Bench, run
from voa_client import DeniedError, Problem, TimedOutError, UnexpectedResponseError, UnreachableError, VoaClientError
from voa_client._errors import refusal
from voa_console.context import Console
from voa_console.keys.access import Admitted, own_page
from voa_console.sentences import needs_key, sentence_of
from voa_service.access.keys import id_of
from voa_service.settings import RateSettings


@pytest.fixture(scope="module")
def sessions(service: Service, data_id: str) -> tuple[str, str]:
    """Two sessions of a service that needs keys from now on."""
    opened = service.open(data_id), service.open(data_id)
    key_for(service, "operator")
    return opened


@pytest.mark.parametrize(
    ("role", "calls"),
    [
        ("viewer", set[str]()),
        ("sensor", {"robot.look", "look.announce"}),
        ("arm", {"outcome.report"}),
        (
            "operator",
            {"robot.look", "look.announce", "outcome.report", "belief.put", "session.create", "scenario.create"},
        ),
    ],
)
def test_a_console_knows_what_its_key_may_do(
    service: Service, sessions: tuple[str, str], role: Any, calls: set[str]
) -> None:
    key = key_for(service, role)

    async def story(bench: Bench) -> None:
        console = await bench.console(await bench.access.enter(key, None))
        every = ("robot.look", "look.announce", "outcome.report", "belief.put", "session.create", "scenario.create")
        assert {call for call in every if console.may(call)} == calls
        assert console.may("history.get")

    run(service, story)


def test_a_key_for_certain_sessions_and_robots_opens_no_session(service: Service, sessions: tuple[str, str]) -> None:
    key = key_for(service, "operator", sessions=sessions[:1], robots=("tb3_1",))

    async def story(bench: Bench) -> None:
        console = await bench.console(await bench.access.enter(key, None))
        assert not console.may("session.create")
        assert console.may("belief.put")
        assert [console.may_use_robot(robot) for robot in ("tb3_1", "tb3_2")] == [True, False]

    run(service, story)


def test_a_key_that_is_revoked_is_refused_with_the_reason_and_forgotten(
    service: Service, sessions: tuple[str, str]
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        secret = await bench.access.enter(key, None)
        console = await bench.console(secret)
        closed: list[Console] = []

        async def closing(each: Console) -> None:
            closed.append(each)

        bench.access.consoles.on_close(closing)
        revoke_key(url_of(service.database), key)
        service.inside.gate.keyring.refresh()
        assert await bench.console(secret) is console, "it was identified a moment ago"
        bench.now = 10.0
        refusal = await bench.access.admit(secret)
        assert isinstance(refusal, str)
        assert "was revoked: use another one" in refusal
        assert console.caller is None
        await asyncio.gather(*(task for task in bench.access._tasks if task.get_name() == "voa-console-close"))
        assert closed == [console]
        assert bench.lines.made[-1].is_closed
        assert await bench.access.admit(secret) == ""

    run(service, story)


def problem(status: int, kind: str) -> VoaClientError:
    body = Problem(type=f"urn:voa:problem:{kind}", title="Title", status=status, detail="it failed")
    return refusal(body, 3.0 if status in (429, 503) else None)


@pytest.mark.parametrize(
    "error",
    [UnreachableError("cut"), problem(503, "not-ready"), problem(429, "too-many-requests"), None],
    ids=["unreachable", "not ready", "key called too often", "no answer"],
)
def test_while_the_service_does_not_respond_browsers_are_admitted_that_were_before_and_no_others(
    service: Service, sessions: tuple[str, str], error: VoaClientError | None
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        secret = await bench.access.enter(key, None)
        console = await bench.console(secret)
        bench.fail(error)
        bench.now = 10.0
        assert await bench.console(secret) is console
        assert console.may("history.get")
        for stranger in (None, "no secret"):
            assert await bench.access.admit(stranger) == sentence_of(error or TimedOutError())
        assert bench.access.consoles.own.hub.error is not None, "the page of the key says it, too"

    run(service, story)


@pytest.mark.parametrize(
    "error",
    [problem(500, "internal"), problem(404, "http-error"), problem(403, "forbidden"), UnexpectedResponseError("HTML")],
    ids=["defect", "proxy", "forbidden", "another program"],
)
def test_another_answer_than_the_caller_admits_nobody_and_no_key_is_forgotten_for_it(
    service: Service, sessions: tuple[str, str], error: VoaClientError
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        secret = await bench.access.enter(key, None)
        console = await bench.console(secret)
        bench.fail(error)
        bench.now = 10.0
        assert [await bench.access.admit(each) for each in (secret, None)] == [sentence_of(error)] * 2
        for line in bench.lines.made:
            line.error = None
        assert await bench.console(secret) is console

    run(service, story)


@pytest.mark.parametrize("error", [UnreachableError("cut"), problem(500, "internal")], ids=["unreachable", "defect"])
def test_a_service_that_is_known_to_have_no_keys_admits_everybody_whatever_it_answers(
    tmp_path: Path, error: VoaClientError
) -> None:
    async def story(bench: Bench) -> None:
        own = await bench.console(None)
        bench.fail(error)
        bench.now = 10.0
        assert await bench.console(None) is own

    with serving(tmp_path) as service:
        run(service, story)


def test_beyond_the_rate_of_calls_without_a_valid_key_only_browsers_with_a_valid_key_are_admitted(
    tmp_path: Path,
) -> None:
    async def story(bench: Bench, service: Service, viewer: str, other: str) -> None:
        assert await bench.access.admit(None) == "", "refused with 401"
        refused = await bench.access.admit(None)
        assert isinstance(refused, str)
        assert re.search(r"no valid key, and too many such calls: .* try again in \d+ s\.", refused)
        with pytest.raises(DeniedError, match="more than 1 calls without a valid key"):
            await bench.access.enter(NONSENSE, None)
        secrets = [await bench.access.enter(key, None) for key in (viewer, other)]
        revoke_key(url_of(service.database), viewer)
        service.inside.gate.keyring.refresh()
        bench.now = 10.0
        console = bench.access.consoles._of_keys[id_of(viewer) or ""]
        refused = await bench.access.admit(secrets[0])
        assert isinstance(refused, str)
        assert "no valid key" in refused
        assert console.caller is None
        assert needs_key(console.hub.error), "its open pages leave"
        for nobody in (secrets[0], None):
            assert isinstance(await bench.access.admit(nobody), str)
        assert (await bench.console(secrets[1])).may("history.get")

    with serving(tmp_path, rates=RateSettings(refused="1/hour")) as service:
        viewer, other = key_for(service, "viewer"), key_for(service, "arm")
        run(service, lambda bench: story(bench, service, viewer, other))


def test_a_console_with_a_key_of_its_own_serves_everybody_by_it_and_a_browser_may_give_another(
    service: Service, sessions: tuple[str, str]
) -> None:
    viewer, operator = key_for(service, "viewer"), key_for(service, "operator")

    async def story(bench: Bench) -> None:
        admitted = await bench.access.admit(None)
        assert isinstance(admitted, Admitted)
        assert admitted.is_own
        assert not admitted.console.may("session.create")
        secret = await bench.access.enter(operator, None)
        assert (await bench.console(secret)).may("session.create")
        assert not (await bench.console("no secret")).may("session.create")
        assert secret is not None
        bench.access.leave(secret)
        assert await bench.console(secret) is bench.access.consoles.own

    run(service, story, own=viewer)


def test_a_key_that_is_forgotten_while_a_page_is_requested_admits_it_no_more(
    service: Service, sessions: tuple[str, str]
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        secret = await bench.access.enter(key, None)
        assert secret is not None
        bench.now = 10.0
        requested = asyncio.create_task(bench.access.admit(secret))
        await asyncio.sleep(0)  # it waits for the service
        bench.access.leave(secret)
        assert await requested == ""

    run(service, story)


def test_a_key_that_expires_is_refused(service: Service, sessions: tuple[str, str]) -> None:
    ends = datetime.now(UTC) - timedelta(seconds=1.0)
    key = make_key(url_of(service.database), "viewer", expires_at=ends)
    service.inside.gate.keyring.refresh()

    async def story(bench: Bench) -> None:
        with pytest.raises(DeniedError, match="expired at"):
            await bench.access.enter(key, None)
        assert bench.lines.made[-1].is_closed

    run(service, story)


@pytest.mark.parametrize(
    ("path", "leads_to"),
    [
        ("/", "/"),
        ("/new?of=0a1b", "/new?of=0a1b"),
        ("/robots", "/robots"),
        ("/sessions/ab-1.2_3", "/sessions/ab-1.2_3"),
        ("/sessions/a/b", "/"),
        ("/robots?x=1", "/"),
        ("//robots", "/"),
        ("/robots\n", "/"),
        ("http://evil.example/robots", "/"),
    ],
)
def test_a_browser_is_led_to_pages_of_the_console_alone(path: str, leads_to: str) -> None:
    assert own_page(path) == leads_to
