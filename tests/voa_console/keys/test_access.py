"""Each key has a console of its own, which shows what that key may see, for as long as the service accepts it."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from tests.support.api_keys import key_for, make_key, revoke_key, url_of
from tests.support.serving import Service
from tests.support.waiting import SECONDS
from tests.voa_console.keys.doors import URL, Lines
from voa_client import DeniedError
from voa_console.context import Console
from voa_console.keys.access import Access, Admitted, own_page
from voa_console.settings import ConsoleSettings


class Bench:
    """Access to a console, with the clients that it has made."""

    def __init__(self, service: Service, own: str | None = None) -> None:
        self.now = 0.0
        self.lines = Lines(service, own)
        self.access = Access(ConsoleSettings(URL), self.lines.connect, lambda: self.now, SECONDS)

    async def console(self, secret: str | None) -> Console:
        """Console by which a browser is admitted."""
        admitted = await self.access.admit(secret)
        assert isinstance(admitted, Admitted), admitted
        return admitted.console


@asynccontextmanager
async def opened(service: Service, own: str | None = None) -> AsyncIterator[Bench]:
    bench = Bench(service, own)
    bench.access.start()
    yield bench
    await bench.access.close()
    assert all(line.is_closed for line in bench.lines.made)


def run(service: Service, story: Callable[[Bench], Coroutine[Any, Any, None]], own: str | None = None) -> None:
    async def whole() -> None:
        async with opened(service, own) as bench:
            await story(bench)

    asyncio.run(whole())


@pytest.fixture(scope="module")
def sessions(service: Service, data_id: str) -> tuple[str, str]:
    """Two sessions of a service that needs keys from now on."""
    opened = service.open(data_id), service.open(data_id)
    key_for(service, "operator")
    return opened


def test_two_keys_share_no_client_and_no_hub_and_two_browsers_with_one_key_share_both(
    service: Service, sessions: tuple[str, str]
) -> None:
    viewer, arm = key_for(service, "viewer", sessions=sessions[:1]), key_for(service, "arm")

    async def story(bench: Bench) -> None:
        secrets = [await bench.access.enter(key, None) for key in (viewer, arm, viewer)]
        consoles = [await bench.console(secret) for secret in secrets]
        assert consoles[0] is consoles[2]
        assert consoles[0].hub is not consoles[1].hub
        assert consoles[0].client is not consoles[1].client
        assert consoles[0].part(id) == consoles[2].part(id)
        assert consoles[0].part(id) != consoles[1].part(id)
        assert bench.access.consoles.own not in consoles
        assert consoles[0].may_see_session(sessions[0])
        assert not consoles[0].may_see_session(sessions[1])
        assert consoles[1].may_see_session(sessions[1])

    run(service, story)


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


def test_while_the_service_does_not_respond_browsers_are_admitted_as_before(
    service: Service, sessions: tuple[str, str]
) -> None:
    key = key_for(service, "viewer")

    async def story(bench: Bench) -> None:
        assert await bench.access.admit(None) == ""
        secret = await bench.access.enter(key, None)
        console = await bench.console(secret)
        for line in bench.lines.made:
            line.is_cut = True
        bench.now = 10.0
        assert await bench.console(secret) is console
        assert console.may("history.get")
        stranger = await bench.console(None)
        assert stranger is bench.access.consoles.own, "it shows that the service does not respond"
        assert not stranger.may("history.get")
        assert stranger.hub.sessions() == []

    run(service, story)


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
