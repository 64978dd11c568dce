"""Worker threads: started when they are needed, reused, and left behind at the end where a call hangs."""

import threading
from concurrent.futures import CancelledError, Future
from typing import Any

import pytest

from tests.support.waiting import wait_for
from tests.voa_service.runtime.test_queues import Gate
from voa_service.runtime.workers import Workers

LONG_S = 30.0


def submitted(workers: Workers, work: Any) -> "Future[Any]":
    future: Future[Any] = Future()
    workers.submit(future, work)
    return future


def threads(name: str) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(f"voa-{name}-")]


def test_results_and_errors_are_given_to_the_future() -> None:
    workers = Workers("results", 1)

    def failing() -> None:
        raise LookupError("gone")

    assert submitted(workers, lambda: 7).result(LONG_S) == 7
    with pytest.raises(LookupError, match="gone"):
        submitted(workers, failing).result(LONG_S)
    assert submitted(workers, lambda: 8).result(LONG_S) == 8, "an error ends no thread"
    workers.close(LONG_S)


def test_no_more_threads_are_started_than_there_are_calls_or_than_allowed() -> None:
    workers, gate = Workers("few", 2), Gate()
    assert threads("few") == []
    futures = [submitted(workers, gate.work(0))]
    assert len(threads("few")) == 1
    futures += [submitted(workers, gate.work(number)) for number in (1, 2)]
    assert len(threads("few")) == 2
    assert all(thread.daemon for thread in threads("few"))
    gate.open.set()
    assert [future.result(LONG_S) for future in futures] == [0, 1, 2]
    workers.close(LONG_S)
    assert threads("few") == []


def test_a_cancelled_call_is_not_made() -> None:
    workers, gate = Workers("cancelled", 1), Gate()
    first, second = submitted(workers, gate.work(0)), submitted(workers, gate.work(1))
    assert gate.begun.acquire(timeout=LONG_S)
    assert second.cancel()
    gate.open.set()
    assert first.result(LONG_S) == 0
    workers.close(LONG_S)
    assert gate.done == [0]


def test_the_end_cancels_the_calls_that_wait_and_leaves_one_that_hangs_behind() -> None:
    workers, gate = Workers("hanging", 1), Gate()
    hanging, waiting = submitted(workers, gate.work(0)), submitted(workers, gate.work(1))
    assert gate.begun.acquire(timeout=LONG_S)
    workers.close(0.0)
    with pytest.raises(CancelledError):
        waiting.result(0.0)
    assert submitted(workers, gate.work(2)).cancelled()
    assert not hanging.done()
    gate.open.set()
    assert hanging.result(LONG_S) == 0
    wait_for(lambda: threads("hanging") == [], "the thread to end")
    assert gate.done == [0]
