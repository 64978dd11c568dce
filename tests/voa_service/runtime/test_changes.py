"""Changes of sessions: a watcher wakes for its own session, and a listener receives each commit of this process."""

import asyncio
from typing import Any, cast

from voa_service.runtime.changes import Changes, Watch
from voa_store.records import SessionState

LONG_S = 30.0
STATE = cast(SessionState, object())


async def wakes(watch: Watch) -> None:
    """Wait for a change; fails where none comes."""
    async with asyncio.timeout(LONG_S / 2):
        await watch.wait(LONG_S)


def test_a_watcher_wakes_for_a_change_of_its_session_alone() -> None:
    async def story() -> None:
        changes = Changes()
        with changes.watching("S") as watch, changes.watching("T") as other:
            changes.changed("S")
            await wakes(watch)
            began = asyncio.get_running_loop().time()
            await other.wait(0.01)
            assert asyncio.get_running_loop().time() - began >= 0.01
            assert not watch.closed

    asyncio.run(story())


def test_a_change_before_the_wait_is_not_lost_and_several_wake_once() -> None:
    async def story() -> None:
        changes = Changes()
        with changes.watching("S") as watch:
            changes.changed("S")
            changes.changed("S")
            await wakes(watch)
            began = asyncio.get_running_loop().time()
            await watch.wait(0.01)
            assert asyncio.get_running_loop().time() - began >= 0.01

    asyncio.run(story())


def test_a_change_that_another_thread_announces_wakes_the_loop() -> None:
    async def story() -> None:
        changes = Changes()
        with changes.watching("S") as watch:
            waiting = asyncio.create_task(wakes(watch))
            await asyncio.to_thread(changes.changed, "S")
            await waiting

    asyncio.run(story())


def test_a_commit_reaches_listeners_within_their_block() -> None:
    changes = Changes()
    received: list[tuple[str, Any]] = []
    with changes.listening(lambda session, state: received.append((session, state))):
        changes.committed("S", STATE)
        changes.committed("S", None)
    changes.committed("T", STATE)
    assert received == [("S", STATE), ("S", None)]


def test_the_end_wakes_every_watcher_also_those_to_come() -> None:
    async def story() -> None:
        changes = Changes()
        ended: list[str] = []
        changes.at_close(lambda: ended.append("end"))
        with changes.watching("S") as watch:
            changes.close()
            await wakes(watch)
            assert watch.closed
        with changes.watching("T") as late:
            assert late.closed
        assert ended == ["end"]

    asyncio.run(story())
