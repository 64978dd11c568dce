"""Samples that a mailbox keeps for who reads slowly, and of a flood."""

import asyncio
import threading
from collections.abc import Callable

import pytest

from tests.voa_client.stepping import body
from voa_client._mailbox import MOST_BODIES, MOST_BYTES, MOST_NEWS, MOST_VERSIONS, AsyncMailbox, Batch, Mailbox
from voa_client._transport import Deleted, Hint, News, State

SECONDS = 30.0


def in_thread(put: list[News], seen: int | None = None) -> Batch:
    box = Mailbox(seen)
    for each in put:
        box.put(each)
    return box.take(0.0, seen)


def in_loop(put: list[News], seen: int | None = None) -> Batch:
    async def main() -> Batch:
        box = AsyncMailbox(seen)
        for each in put:
            box.put(each)
        return await box.take(0.0, seen)

    return asyncio.run(main())


@pytest.fixture(params=[in_thread, in_loop])
def boxed(request: pytest.FixtureRequest) -> Callable[..., Batch]:
    result: Callable[..., Batch] = request.param
    return result


def test_the_newest_of_the_service_s_own_are_kept(boxed: Callable[..., Batch]) -> None:
    states: list[News] = [State(body(version)) for version in range(MOST_NEWS + 500)]
    assert list(boxed([*states, Deleted()]).news) == [*states[501:], Deleted()]
    assert boxed([]).is_empty


def test_hints_of_known_versions_are_dropped_and_others_cause_a_request(boxed: Callable[..., Batch]) -> None:
    assert boxed([Hint(3, b"a"), Hint(2, b"b")], seen=3).is_empty
    assert boxed([Hint(None)], seen=3) == Batch(hinted=True)
    assert boxed([Hint(4)], seen=3) == Batch(hinted=True)
    assert boxed([Hint(4, b"a"), Hint(4, b"a"), Hint(4, b"b")], seen=3) == Batch((), True, {4: [b"a", b"b"]})


def test_a_flood_is_bounded_and_leaves_the_lowest_versions(boxed: Callable[..., Batch]) -> None:
    flood: list[News] = [Hint(10**6 + number, b"forged") for number in range(5_000)]
    batch = boxed([*flood, *[Hint(version, b"true") for version in (1, 2, 3)], *flood, *[Hint(None)] * 1_000])
    assert [batch.bodies[version] for version in (1, 2, 3)] == [[b"true"]] * 3
    assert len(batch.bodies) == MOST_VERSIONS
    prefilled = boxed([*[Hint(1, b"%d" % number) for number in range(100)], Hint(1, b"true"), Hint(1, b"late")])
    assert len(prefilled.bodies[1]) == MOST_BODIES
    assert prefilled.bodies[1][-2:] == [b"true", b"late"]


def test_large_bodies_are_bounded_too(boxed: Callable[..., Batch]) -> None:
    large: list[News] = [Hint(10 + number, bytes(MOST_BYTES // 4)) for number in range(20)]
    batch = boxed([*large, Hint(1, b"true"), Hint(2, bytes(MOST_BYTES + 1))])
    assert batch.hinted
    assert batch.bodies[1] == [b"true"]
    assert sum(len(each) for bodies in batch.bodies.values() for each in bodies) <= MOST_BYTES


def test_who_waits_is_woken_from_another_thread() -> None:
    box = Mailbox()
    threading.Timer(0.05, box.put, [Hint(0)]).start()
    assert box.take(SECONDS, None).hinted

    async def main() -> list[bool]:
        own = AsyncMailbox()
        result = []
        for _ in range(3):
            threading.Timer(0.05, own.put, [Hint(7)]).start()
            result.append((await own.take(SECONDS, None)).hinted)
        assert (await own.take(0.0, None)).is_empty
        return result

    assert asyncio.run(main()) == [True] * 3


def test_what_is_put_after_the_loop_has_ended_is_nobody_s() -> None:
    async def made() -> AsyncMailbox:
        return AsyncMailbox()

    asyncio.run(made()).put(Hint(1))
