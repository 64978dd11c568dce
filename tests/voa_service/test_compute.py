"""Work off the event loop: refused when there is too much of it, never lost, never in the loop's way."""

import asyncio
import threading
from collections.abc import Callable, Iterator

import pytest

from tests.serving import Service, data_scenario, serving
from voa_service.compute import Threads, WorkQueue
from voa_service.failures import Failure


class Gate:
    """Work that begins, and ends when it is let through."""

    def __init__(self) -> None:
        self.begun = threading.Semaphore(0)
        self.open = threading.Event()
        self.done: list[int] = []

    def work(self, number: int) -> Callable[[], int]:
        def run() -> int:
            self.begun.release()
            assert self.open.wait(30)
            self.done.append(number)
            return number

        return run


async def began(gate: Gate, count: int) -> None:
    for _ in range(count):
        assert await asyncio.to_thread(gate.begun.acquire, True, 30)


def test_one_more_than_fits_is_refused_and_everything_else_is_done() -> None:
    gate = Gate()

    async def story() -> list[int]:
        queue = WorkQueue("heavy", workers=2, waiting=3)
        tasks = [asyncio.create_task(queue.run(gate.work(i))) for i in range(5)]
        await began(gate, 2)  # the loop runs while both workers are at it
        assert queue.inside == 5
        with pytest.raises(Failure) as refused:
            await queue.run(gate.work(99))
        assert (refused.value.kind, refused.value.status) == ("overloaded", 503)
        assert int(refused.value.headers["Retry-After"]) >= 1
        assert "heavy" in refused.value.detail
        gate.open.set()
        results = await asyncio.gather(*tasks)
        assert queue.inside == 0
        assert await queue.run(lambda: 7) == 7
        return results

    assert asyncio.run(story()) == [0, 1, 2, 3, 4]
    assert sorted(gate.done) == [0, 1, 2, 3, 4]


def test_work_that_fails_makes_room_too() -> None:
    def fail() -> None:
        raise LookupError("gone")

    async def story() -> int:
        queue = WorkQueue("quick", workers=1, waiting=1)
        for _ in range(5):
            with pytest.raises(LookupError, match="gone"):
                await queue.run(fail)
        return queue.inside

    assert asyncio.run(story()) == 0


def test_work_whose_caller_has_gone_counts_until_it_ends() -> None:
    gate = Gate()

    async def story() -> None:
        queue = WorkQueue("heavy", workers=1, waiting=1)
        task = asyncio.create_task(queue.run(gate.work(1)))
        await began(gate, 1)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert queue.inside == 1
        waiting = asyncio.create_task(queue.run(gate.work(2)))
        await asyncio.to_thread(lambda: None)
        with pytest.raises(Failure):
            await queue.run(gate.work(3))
        gate.open.set()
        assert await waiting == 2
        assert queue.inside == 0

    asyncio.run(story())
    assert gate.done == [1, 2]


def test_threads_give_results_in_the_order_of_the_items() -> None:
    threads = Threads(3)
    try:
        assert list(threads(lambda item: item * item, range(20))) == [item * item for item in range(20)]
    finally:
        threads.close()


@pytest.fixture
def crowded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("crowded"), workers=1, queue=1, scan_queue=1) as service:
        yield service


def test_a_service_with_too_much_to_do_says_503_and_still_answers_what_needs_no_worker(crowded: Service) -> None:
    scenario = crowded.create(data_scenario())
    gate = Gate()
    heavy = crowded.inside.heavy
    portal = crowded.http.portal
    assert portal is not None
    held = [portal.start_task_soon(heavy.run, gate.work(i)) for i in range(2)]
    assert gate.begun.acquire(timeout=30)
    body = {"scenario": scenario, "belief": [0.2, 0.3, 0.5]}
    refused = crowded.http.post("/v1/rankings", json=body)
    assert refused.status_code == 503
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.json()["type"] == "urn:voa:problem:overloaded"
    assert int(refused.headers["retry-after"]) >= 1
    assert crowded.get("/livez") == {"status": "alive"}  # the event loop is free
    assert crowded.get(f"/v1/scenarios/{scenario}")["id"] == scenario  # and so are the quick workers
    gate.open.set()
    assert [future.result(30) for future in held] == [0, 1]
    assert crowded.post("/v1/rankings", body)["version"] is None
