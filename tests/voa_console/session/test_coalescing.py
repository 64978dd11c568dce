"""Work that is requested more often than it can be done."""

import asyncio

import pytest
from nicegui import core

from voa_console.session.coalescing import Coalesced


def test_requests_during_the_work_are_put_together(monkeypatch: pytest.MonkeyPatch) -> None:
    async def run() -> int:
        monkeypatch.setattr(core, "loop", asyncio.get_running_loop())
        count = 0
        going_on = asyncio.Event()
        done = asyncio.Event()

        async def work() -> None:
            nonlocal count
            count += 1
            done.set()
            await going_on.wait()

        coalesced = Coalesced(work, "test")
        coalesced.request()
        await done.wait()
        for _ in range(5):
            coalesced.request()
        going_on.set()
        for _ in range(10):
            await asyncio.sleep(0)
        before = count
        coalesced.request()
        for _ in range(10):
            await asyncio.sleep(0)
        assert before == 2
        return count

    assert asyncio.run(run()) == 3
