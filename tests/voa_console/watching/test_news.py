"""Callbacks of pages, and changes that come quickly one after the other."""

import asyncio

from voa_console.watching.news import News


def test_quick_changes_are_published_together_the_first_at_once_and_the_last_soon() -> None:
    async def story() -> None:
        news = News()
        calls: list[float] = []
        last = asyncio.Event()

        def note() -> None:
            calls.append(asyncio.get_running_loop().time())
            if len(calls) == 2:
                last.set()

        news.subscribe(note)
        for _ in range(50):
            news.publish_soon()
        assert len(calls) == 1
        await asyncio.wait_for(last.wait(), 20.0)
        assert len(calls) == 2

    asyncio.run(story())


def test_a_subscription_ends_once() -> None:
    async def story() -> None:
        news = News()
        calls: list[int] = []
        leave = news.subscribe(lambda: calls.append(1))
        news.publish()
        leave()
        leave()
        news.publish()
        assert calls == [1]
        assert len(news) == 0

    asyncio.run(story())
