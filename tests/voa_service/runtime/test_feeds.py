"""A watched session is read once for all its followers, who take its versions in order at their own pace."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager

import pytest

from voa_service.failures import Failure, NotReady
from voa_service.http.routes.events import EventStream, events_of
from voa_service.runtime.changes import Changes
from voa_service.runtime.feeds import Feeds, Version

PAGE = 5
SESSION = "s"


class World:
    """A session that moves, and how often it was read."""

    def __init__(self, most: int = 100, body: str = "{}") -> None:
        self.changes = Changes()
        self.version: int | None = 0
        self.reads = 0
        self.failing = False
        self.body = body
        self.feeds = Feeds(self.changes, self.fetch, most)

    async def fetch(self, session: str, seen: int | None) -> Sequence[Version] | None:
        assert session == SESSION
        self.reads += 1
        await asyncio.sleep(0)
        if self.failing:
            raise NotReady("the database is away")
        if self.version is None:
            return None
        newest = self.version
        first = newest if seen is None or seen > newest else seen + 1
        return [Version(number, self.body) for number in range(first, min(newest, first + PAGE - 1) + 1)]

    def move(self, versions: int = 1) -> None:
        assert self.version is not None
        self.version += versions
        self.changes.changed(SESSION)

    @asynccontextmanager
    async def following(self, seen: int | None = None) -> AsyncIterator[Callable[[], Awaitable[str]]]:
        first = await self.feeds.first(SESSION, seen)
        assert first is not None
        events = events_of(self.feeds, SESSION, seen, first, lambda: True)

        async def following() -> str:
            async with asyncio.timeout(30):
                lines = (await anext(events)).decode().splitlines()
            fields = {line.partition(": ")[0]: line.partition(": ")[2] for line in lines}
            return fields.get("id", fields["event"])

        try:
            yield following
        finally:
            await events.aclose()  # type: ignore[attr-defined] # a generator, typed as an iterator


def test_followers_of_one_session_share_its_reads() -> None:
    async def story(followers: int) -> int:
        world = World()
        async with asyncio.timeout(60):
            streams = [world.following() for _ in range(followers)]
            nexts = [await stream.__aenter__() for stream in streams]
            assert [await each() for each in nexts] == ["0"] * followers
            begun = world.reads
            for version in range(1, 11):
                world.move()
                assert [await each() for each in nexts] == [str(version)] * followers
            for stream in streams:
                await stream.__aexit__(None, None, None)
            assert (world.feeds.watched, world.feeds.followers) == (0, 0)
            return world.reads - begun

    alone, many = asyncio.run(story(1)), asyncio.run(story(200))
    assert many <= 2 * alone + 10


@pytest.mark.parametrize(("seen", "expected"), [(None, [12, 13]), (0, range(1, 14)), (7, range(8, 14)), (99, [12, 13])])
def test_each_follower_has_its_own_beginning(seen: int | None, expected: Sequence[int]) -> None:
    async def story() -> None:
        world = World()
        world.move(12)
        async with world.following() as other:  # a feed that is at hand from version 12 on
            assert await other() == "12"
            async with world.following(seen) as following:
                before = [await following() for _ in expected[:-1]]
                world.move()
                assert [*before, await following()] == [str(version) for version in expected]
                assert await other() == "13"

    asyncio.run(story())


def test_a_follower_that_lags_behind_what_is_at_hand_gets_every_version() -> None:
    async def story() -> None:
        world = World(body="x" * 2**17)  # two versions are at hand
        async with world.following() as slow, world.following() as quick:
            assert (await slow(), await quick()) == ("0", "0")
            for version in range(1, 15):
                world.move()
                assert await quick() == str(version)
            assert [await slow() for _ in range(14)] == [str(version) for version in range(1, 15)]

    asyncio.run(story())


def test_a_store_that_is_away_for_a_while_loses_no_version() -> None:
    async def story() -> None:
        world = World()
        async with world.following() as following:
            assert await following() == "0"
            world.failing = True
            reads = world.reads
            world.move(3)
            while world.reads == reads:
                await asyncio.sleep(0)
            world.failing = False
            assert [await following() for _ in range(3)] == ["1", "2", "3"]

    asyncio.run(story())


def test_a_session_that_is_gone_ends_the_streams_of_all() -> None:
    async def story() -> None:
        world = World()
        async with world.following() as one, world.following() as other:
            assert (await one(), await other()) == ("0", "0")
            world.version = None
            world.changes.changed(SESSION)
            for following in (one, other):
                assert await following() == "deleted"
                with pytest.raises(StopAsyncIteration):
                    await following()
        assert await world.feeds.first(SESSION, None) is None

    asyncio.run(story())


def test_a_service_that_ends_ends_every_stream() -> None:
    async def story() -> None:
        world = World()
        async with world.following() as one, world.following() as other:
            assert (await one(), await other()) == ("0", "0")
            world.changes.close()
            for following in (one, other):
                with pytest.raises(StopAsyncIteration):
                    await following()

    asyncio.run(story())


def test_one_follower_more_than_there_may_be_is_refused() -> None:
    async def story() -> Failure:
        world = World(most=2)
        async with world.following() as one, world.following() as other:
            assert (await one(), await other()) == ("0", "0")
            with pytest.raises(Failure, match="2 event streams") as refused:
                await world.feeds.first(SESSION, None)
        assert await world.feeds.first(SESSION, None) is not None
        return refused.value

    assert asyncio.run(story()).status == 503


def test_a_follower_that_takes_nothing_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voa_service.http.routes.events._STALLED_SECONDS", 0.01)

    async def story() -> int:
        world = World()
        events = events_of(world.feeds, SESSION, None, await world.feeds.first(SESSION, None) or (), lambda: True)

        async def stalled(message: object) -> None:
            await asyncio.Event().wait()

        async def receive() -> dict[str, str]:
            await asyncio.Event().wait()
            return {"type": "http.disconnect"}

        async with asyncio.timeout(30):
            await EventStream(events)({"type": "http"}, receive, stalled)
        await events.aclose()  # type: ignore[attr-defined] # a generator, typed as an iterator
        return world.feeds.followers

    assert asyncio.run(story()) == 0
