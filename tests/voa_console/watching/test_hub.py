"""The hub requests and follows everything once for all pages, and survives a service that goes away."""

import asyncio
import logging
from collections import Counter
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager, suppress
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.support.api_keys import key_for
from tests.support.serving import Service, data_scenario, scan_of, serving
from voa_client import AsyncClient, AsyncInProcessTransport, NotFoundError, Retries, UnreachableError
from voa_console.sentences import needs_key
from voa_console.watching.hub import Hub
from voa_service.rpc.entry import Rpc

POLL_S = 0.02
GOOD = [0.5, 0.5, None, 1.0]


class Counting(AsyncInProcessTransport):
    """Transport that counts calls, and that can be cut."""

    def __init__(self, service: Service) -> None:
        super().__init__(Rpc(service.inside))
        self.calls: Counter[str] = Counter()
        self.is_cut = False

    async def send(self, call: Any, key: str | None, seconds: float) -> Any:
        self.calls[call.rpc] += 1
        if self.is_cut:
            raise UnreachableError("cut")
        return await super().send(call, key, seconds)


class Bench:
    """Hub of a service in this process."""

    def __init__(self, service: Service) -> None:
        self.service = service
        self.transport = Counting(service)
        self.client = AsyncClient(self.transport, retries=Retries(first_s=0.01, most_s=0.02, within_s=0.05))
        self.hub = Hub(self.client, poll_s=POLL_S)

    def apply(self, session: str) -> None:
        self.service.post(f"/v1/sessions/{session}/scans", scan_of(GOOD))

    async def until(self, condition: Callable[[], object]) -> None:
        """Wait for a condition, which is looked at whenever the hub has news."""
        event = asyncio.Event()
        leave = self.hub.subscribe(event.set)
        async with asyncio.timeout(20.0):
            while not condition():
                await event.wait()
                event.clear()
        leave()


@asynccontextmanager
async def running(service: Service) -> AsyncIterator[Bench]:
    bench = Bench(service)
    task = asyncio.create_task(bench.hub.run())
    try:
        yield bench
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


def run(service: Service, story: Callable[[Bench], Coroutine[Any, Any, None]]) -> None:
    async def whole() -> None:
        async with running(service) as bench:
            await story(bench)

    asyncio.run(whole())


@pytest.fixture
def session(service: Service, data_id: str) -> str:
    return service.open(data_id)


def test_nothing_is_requested_while_no_page_is_open(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        close = bench.hub.open_page()
        await bench.until(lambda: bench.hub.has_responded)
        close()
        close()  # a page that closes twice counts once
        watched = bench.hub.watch(session)
        while watched.is_followed:
            await bench.client.lidars()
        before = bench.transport.calls.copy()
        bench.apply(session)
        for _ in range(50):  # time in which the hub, at 20 ms, would request everything again
            await bench.client.lidars()
        assert bench.transport.calls - before == Counter({"lidar.list": 50})
        bench.hub.open_page()
        await bench.until(lambda: (now := bench.hub.watch(session).session) is not None and now.version == 1)

    run(service, story)


def test_a_session_is_followed_once_however_many_pages_show_it(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        watched = bench.hub.watch(session)
        counts = Counter[int]()
        arrived = asyncio.Event()

        def page(number: int) -> Callable[[], None]:
            def show() -> None:
                counts[number] += 1
                arrived.set()

            return show

        leaves = [watched.subscribe(page(number)) for number in range(20)]
        assert await watched.ready()
        assert bench.hub.watch(session) is watched
        assert bench.transport.calls["session.get"] == 1
        assert bench.transport.calls["scenario.get"] == 1
        assert {counts[number] for number in range(20)} == {1}
        for leave in leaves:
            leave()
        assert not watched.is_followed

    run(service, story)


def test_the_history_is_read_where_looks_do_not_explain_a_version(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        bench.hub.open_page()
        watched = bench.hub.watch(session)
        watched.subscribe(lambda: None)
        bench.apply(session)
        await bench.until(lambda: watched.session is not None and watched.session.version == 1)
        assert (watched.newest, bench.transport.calls["history.get"]) == (None, 0)
        service.post(f"/v1/sessions/{session}/grasp-outcomes", {"grasp": "G1", "success": False})
        await bench.until(lambda: watched.newest is not None and watched.newest.version == 2)
        assert watched.newest is not None
        assert watched.newest.kind == "outcome"
        bench.apply(session)
        await bench.until(lambda: watched.session is not None and watched.session.version == 3)
        assert bench.transport.calls["history.get"] == 1

    run(service, story)


def test_sessions_that_moved_last_come_first(service: Service, data_id: str) -> None:
    opened = [service.open(data_id) for _ in range(3)]

    async def story(bench: Bench) -> None:
        bench.hub.open_page()
        await bench.until(lambda: bench.hub.has_responded)
        hub = Hub(bench.client, poll_s=POLL_S)
        ages = dict(zip(opened, (300.0, 30.0, 120.0), strict=True))
        listed = [each for each in bench.hub._summaries if each.id in ages]
        now = hub.now()
        hub._summaries = [
            each.model_copy(update={"updated_at": now - timedelta(seconds=ages[each.id])}) for each in listed
        ]
        assert [each.id for each in hub.sessions()] == [opened[1], opened[2], opened[0]]
        hub._summaries = [
            each.model_copy(update={"updated_at": now - timedelta(seconds=ages[each.id] / 10.0)}) for each in listed
        ]
        assert [each.id for each in hub.sessions()] == opened[::-1], "those that move keep their places"

    run(service, story)


def test_a_scenario_is_requested_once_for_its_name(service: Service, session: str, data_id: str) -> None:
    async def story(bench: Bench) -> None:
        assert bench.hub.known_scenario(data_id) is None
        await bench.until(lambda: bench.hub.known_scenario(data_id) is not None)
        assert bench.hub.known_scenario("no-such-scenario") is None
        await bench.client.lidars()
        assert bench.hub.known_scenario("no-such-scenario") is None
        assert bench.transport.calls["scenario.get"] == 2

    run(service, story)


def test_a_ranking_is_computed_once_for_each_version(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        bench.hub.open_page()
        watched = bench.hub.watch(session)
        watched.subscribe(lambda: None)
        rankings = await asyncio.gather(*(watched.ranking() for _ in range(20)))
        assert {ranking.version for ranking in rankings} == {0}
        assert bench.transport.calls["voa.rank"] == 1
        bench.apply(session)
        await bench.until(lambda: watched.session is not None and watched.session.version == 1)
        assert (await watched.ranking()).version == 1
        assert (await watched.ranking()).version == 1
        assert bench.transport.calls["voa.rank"] == 2

    run(service, story)


def test_a_ranking_that_failed_is_requested_again(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        watched = bench.hub.watch(session)
        watched.subscribe(lambda: None)
        await watched.ready()
        bench.transport.is_cut = True
        with pytest.raises(UnreachableError):
            await watched.ranking()
        bench.transport.is_cut = False
        assert (await watched.ranking()).version == 0

    run(service, story)


def test_a_service_that_goes_away_is_noticed_and_so_is_its_return(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        bench.hub.open_page()
        await bench.until(lambda: (now := bench.hub.watch(session).session) is not None and now.version == 0)
        bench.transport.is_cut = True
        await bench.until(lambda: isinstance(bench.hub.error, UnreachableError))
        assert session in [summary.id for summary in bench.hub.sessions()]  # the last state stays
        bench.apply(session)
        bench.transport.is_cut = False
        await bench.until(lambda: bench.hub.error is None)
        await bench.until(lambda: (now := bench.hub.watch(session).session) is not None and now.version == 1)

    run(service, story)


def test_a_page_of_a_session_waits_for_a_service_that_starts_after_it(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        bench.transport.is_cut = True
        bench.client._patience = type(bench.client._patience)(timeout_s=0.1, retries=Retries(within_s=0.05))
        watched = bench.hub.watch(session)
        failed = asyncio.Event()
        watched.subscribe(lambda: failed.set() if watched.error else None)
        await failed.wait()
        bench.transport.is_cut = False
        assert await watched.ready()
        assert watched.error is None

    run(service, story)


def test_a_session_that_is_deleted_or_never_existed_has_ended(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        bench.hub.open_page()
        await bench.until(lambda: bench.hub.watch(session).session is not None)
        watched = bench.hub.watch(session)
        service.http.delete(f"/v1/sessions/{session}")
        await bench.until(lambda: watched.ended)
        await bench.until(lambda: session not in [summary.id for summary in bench.hub.sessions()])
        unknown = bench.hub.watch("no-such-session")
        unknown.subscribe(lambda: None)
        assert not await unknown.ready()
        with pytest.raises(NotFoundError):
            await unknown.ranking()

    run(service, story)


def test_a_page_that_fails_does_not_stop_the_others(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        def broken() -> None:
            raise ValueError("the page is gone")

        bench.hub.subscribe(broken)
        bench.hub.open_page()
        await bench.until(lambda: bench.hub.has_responded)

    run(service, story)


def test_old_sessions_are_not_shown(service: Service, session: str) -> None:
    async def story(bench: Bench) -> None:
        hub = Hub(bench.client, recent_s=0.0, poll_s=POLL_S)
        bench.hub.open_page()
        await bench.until(lambda: bench.hub.has_responded)
        hub._summaries = bench.hub._summaries
        assert session in [summary.id for summary in bench.hub.sessions()]
        assert hub.sessions() == []

    run(service, story)


def test_what_a_key_has_received_is_forgotten_when_the_service_no_longer_accepts_it(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))

        async def story(bench: Bench) -> None:
            bench.hub.open_page()
            await bench.until(lambda: bench.hub.followed(session) is not None)
            assert (await bench.hub.identify()).name == "anonymous"
            key_for(service, "operator")
            await bench.until(lambda: needs_key(bench.hub.error))
            assert bench.hub.caller is None
            assert bench.hub.sessions() == []
            assert bench.hub.robots() == []
            assert bench.hub.followed(session) is None

        run(service, story)
    assert [record for record in caplog.records if record.levelno >= logging.WARNING] == []
