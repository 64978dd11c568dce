"""Work off the event loop: refused when there is too much of it, never lost, never in the loop's way."""

import asyncio
import threading
from collections.abc import Callable, Iterator

import pytest

from tests.support.serving import Service, data_scenario, serving
from voa_service.failures import Failure
from voa_service.runtime.queues import Cancelled, Check, Threads, WorkQueue


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


class Wanted:
    """Shared work that goes on until its check says that nobody waits."""

    def __init__(self) -> None:
        self.begun = threading.Semaphore(0)
        self.go_on = threading.Event()
        self.runs = 0
        self.cancelled = threading.Event()

    def work(self, check: Check) -> str:
        self.runs += 1
        self.begun.release()
        try:
            while not self.go_on.wait(0.001):
                check()
        except Cancelled:
            self.cancelled.set()
            raise
        return "done"


async def leave(*tasks: asyncio.Task[str]) -> None:
    for task in tasks:
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task


def test_equal_calls_are_one_call_with_one_place() -> None:
    async def story() -> tuple[list[str], int]:
        queue, wanted = WorkQueue("heavy", workers=1, waiting=1), Wanted()
        tasks = [asyncio.create_task(queue.share("a", wanted.work)) for _ in range(5)]
        assert await asyncio.to_thread(wanted.begun.acquire, True, 30)
        assert queue.inside == 1
        wanted.go_on.set()
        results = await asyncio.gather(*tasks)
        await queue.share("a", wanted.work)  # one that is done is not shared
        return results, wanted.runs

    assert asyncio.run(story()) == (["done"] * 5, 2)


def test_shared_work_goes_on_until_its_last_caller_has_left() -> None:
    async def story() -> None:
        queue, wanted = WorkQueue("heavy", workers=1, waiting=1), Wanted()
        first, second = (asyncio.create_task(queue.share("a", wanted.work)) for _ in range(2))
        assert await asyncio.to_thread(wanted.begun.acquire, True, 30)
        await leave(first)
        assert not wanted.cancelled.is_set()
        await leave(second)
        assert await asyncio.to_thread(wanted.cancelled.wait, 30)
        await queue.run(lambda: None)  # the worker is free
        assert queue.inside == 0

    asyncio.run(story())


def test_shared_work_in_line_leaves_it_with_its_last_caller_and_never_begins() -> None:
    async def story() -> None:
        queue, wanted, gate = WorkQueue("heavy", workers=1, waiting=1), Wanted(), Gate()
        busy = asyncio.create_task(queue.run(gate.work(1)))
        await began(gate, 1)
        task = asyncio.create_task(queue.share("a", wanted.work))
        while queue.inside < 2:
            await asyncio.sleep(0)
        await leave(task)
        assert queue.inside == 1
        gate.open.set()
        await busy
        assert await queue.run(lambda: 3) == 3
        assert wanted.runs == 0

    asyncio.run(story())


def test_whoever_comes_after_the_last_has_left_is_not_given_what_is_being_cancelled() -> None:
    async def story() -> str:
        queue, first, second = WorkQueue("heavy", workers=1, waiting=1), Wanted(), Wanted()
        task = asyncio.create_task(queue.share("a", first.work))
        assert await asyncio.to_thread(first.begun.acquire, True, 30)
        await leave(task)
        second.go_on.set()
        return await queue.share("a", second.work)

    assert asyncio.run(story()) == "done"


def test_an_error_reaches_every_caller_of_shared_work() -> None:
    def fail(_: Check) -> str:
        raise LookupError("gone")

    async def story() -> list[str | BaseException]:
        queue = WorkQueue("heavy", workers=1, waiting=1)
        return await asyncio.gather(*(queue.share("a", fail) for _ in range(3)), return_exceptions=True)

    assert [str(error) for error in asyncio.run(story())] == ["gone"] * 3


def test_when_the_service_ends_shared_work_ends_after_its_time() -> None:
    async def story() -> Failure:
        now = [100.0]
        queue, wanted = WorkQueue("heavy", workers=1, waiting=1, clock=lambda: now[0]), Wanted()
        task = asyncio.create_task(queue.share("a", wanted.work))
        assert await asyncio.to_thread(wanted.begun.acquire, True, 30)
        queue.end_in(3.0)
        queue.check()
        now[0] = 103.5
        with pytest.raises(Failure) as refused:
            await task
        return refused.value

    assert asyncio.run(story()).kind == "not-ready"


def test_a_close_does_not_wait_for_ever() -> None:
    gate = Gate()
    queue = WorkQueue("heavy", workers=1, waiting=2)
    under_way, in_line = queue.submit(gate.work(1)), queue.submit(gate.work(2))
    assert gate.begun.acquire(timeout=30)
    queue.close(0.01)
    assert in_line.cancelled()
    assert queue.submit(gate.work(3)).cancelled()
    gate.open.set()
    assert under_way.result(30) == 1
    assert gate.done == [1]


def test_when_to_try_again_is_the_mean_duration_of_the_latest_calls_by_the_line_per_worker() -> None:
    now = [0.0]
    queue, gate = WorkQueue("heavy", workers=2, waiting=2, clock=lambda: now[0]), Gate()

    def take(seconds: float) -> None:
        now[0] += seconds

    for seconds in (10.0, 20.0):
        queue.submit(lambda seconds=seconds: take(seconds)).result(30)  # type: ignore[misc] # bound in each round, which mypy cannot infer
    held = [queue.submit(gate.work(i)) for i in range(4)]
    with pytest.raises(Failure, match="try again in 30 s") as refused:
        queue.submit(gate.work(9))
    assert refused.value.headers["Retry-After"] == "30"
    gate.open.set()
    assert [call.result(30) for call in held] == [0, 1, 2, 3]


def test_before_any_call_has_ended_those_under_way_say_when_to_try_again() -> None:
    now = [0.0]
    queue, gate = WorkQueue("heavy", workers=1, waiting=1, clock=lambda: now[0]), Gate()
    held = [queue.submit(gate.work(i)) for i in range(2)]
    assert gate.begun.acquire(timeout=30)
    assert queue.retry_after_s() == 1
    now[0] = 40.0
    assert queue.retry_after_s() == 80
    now[0] = 1e6
    assert queue.retry_after_s() == 600
    gate.open.set()
    assert [call.result(30) for call in held] == [0, 1]


def test_threads_drop_what_has_not_begun_after_an_error() -> None:
    gate = Gate()

    def work(item: int) -> int:
        if item == 0:
            raise LookupError("gone")
        return gate.work(item)()

    threads = Threads(1)
    with pytest.raises(LookupError, match="gone"):
        list(threads(work, range(100)))  # the thread is at the second item at most
    gate.open.set()
    assert list(threads(lambda item: item, [7])) == [7]
    assert gate.done in ([], [1])
    threads.close()


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
