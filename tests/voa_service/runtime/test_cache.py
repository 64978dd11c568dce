"""The cache computes each value once, and drops values when there is no room."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import pytest

from voa_service.runtime.cache import Cache
from voa_service.runtime.queues import Cancelled


@dataclass(frozen=True)
class Block:
    nbytes: int


class Maker:
    """Makes blocks and counts."""

    def __init__(self, nbytes: int = 10) -> None:
        self.made = 0
        self.nbytes = nbytes

    def __call__(self) -> Block:
        self.made += 1
        return Block(self.nbytes)


def test_a_value_is_made_once() -> None:
    cache, make = Cache(100), Maker()
    assert cache.get("a", make) is cache.get("a", make)
    assert make.made == 1
    assert cache.held == 10


def test_the_least_recently_used_goes_first_and_the_budget_holds() -> None:
    cache, makers = Cache(30), {name: Maker() for name in "abcd"}
    for name in ("a", "b", "c", "a", "d"):  # a is used again before d needs room
        cache.get(name, makers[name])
        assert cache.held <= 30
    for name in ("a", "c", "d", "b"):
        cache.get(name, makers[name])
    assert {name: make.made for name, make in makers.items()} == {"a": 1, "b": 2, "c": 1, "d": 1}


def test_a_value_that_alone_exceeds_the_budget_is_handed_out_and_not_kept() -> None:
    cache, small, large = Cache(30), Maker(), Maker(31)
    cache.get("small", small)
    assert cache.get("large", large).nbytes == 31
    assert cache.held == 10
    cache.get("large", large)
    cache.get("small", small)
    assert (large.made, small.made) == (2, 1)


def test_threads_that_request_at_the_same_time_share_one_computation() -> None:
    cache, release, begun = Cache(100), threading.Event(), threading.Event()
    calls = []

    def make() -> Block:
        calls.append(threading.get_ident())
        begun.set()
        assert release.wait(30)
        return Block(10)

    with ThreadPoolExecutor(4) as pool:
        first = pool.submit(cache.get, "a", make)
        assert begun.wait(30)
        others = [pool.submit(cache.get, "a", make) for _ in range(3)]
        release.set()
        values = {id(future.result(30)) for future in [first, *others]}
    assert len(values) == 1
    assert len(calls) == 1


def test_other_keys_do_not_wait() -> None:
    cache, release, begun = Cache(100), threading.Event(), threading.Event()

    def slow() -> Block:
        begun.set()
        assert release.wait(30)
        return Block(1)

    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(cache.get, "slow", slow)
        assert begun.wait(30)
        assert cache.get("quick", Maker()).nbytes == 10
        release.set()
        assert future.result(30).nbytes == 1


def test_a_failure_reaches_everyone_who_waits_and_is_not_kept() -> None:
    cache, release, begun = Cache(100), threading.Event(), threading.Event()

    def fail() -> Block:
        begun.set()
        assert release.wait(30)
        raise LookupError("gone")

    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(cache.get, "a", fail)
        assert begun.wait(30)
        second = pool.submit(cache.get, "a", fail)
        release.set()
        for future in (first, second):
            with pytest.raises(LookupError, match="gone"):
                future.result(30)
    assert cache.get("a", Maker()).nbytes == 10
    assert cache.held == 10


def test_when_the_one_that_computes_is_cancelled_another_that_waits_takes_over() -> None:
    cache, release, begun = Cache(100), threading.Event(), threading.Event()

    def cancelled() -> Block:
        begun.set()
        assert release.wait(30)
        raise Cancelled

    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(cache.get, "a", cancelled)
        assert begun.wait(30)
        second = pool.submit(cache.get, "a", Maker())
        release.set()
        with pytest.raises(Cancelled):
            first.result(30)
        assert second.result(30).nbytes == 10


def test_whoever_is_cancelled_waits_no_longer_for_what_another_computes() -> None:
    cache, release, begun = Cache(100), threading.Event(), threading.Event()

    def slow() -> Block:
        begun.set()
        assert release.wait(30)
        return Block(1)

    def check() -> None:
        raise Cancelled

    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(cache.get, "a", slow)
        assert begun.wait(30)
        with pytest.raises(Cancelled):
            cache.get("a", Maker(), check)
        release.set()
        assert first.result(30).nbytes == 1


def test_a_value_that_is_put_while_it_is_computed_counts_once() -> None:
    cache = Cache(10)

    def make() -> Block:
        cache.put("a", Block(3))
        return Block(4)

    assert cache.get("a", make) == Block(4)
    assert (cache.held, cache.peek("a")) == (4, Block(4))
    cache.drop("a")
    assert cache.held == 0


def test_a_value_that_is_put_replaces_the_other_one_and_its_memory() -> None:
    cache = Cache(10)
    cache.put("a", Block(4))
    cache.put("b", Block(4))
    cache.put("a", Block(5))
    assert cache.held == 9
    assert cache.peek("a") == Block(5)
    cache.put("a", Block(6))  # the least recently used one gives way
    assert (cache.held, cache.peek("b")) == (10, Block(4))
    cache.put("c", Block(1))
    assert (cache.held, cache.peek("b")) == (7, None)
    cache.put("a", Block(11))  # too large to be kept, and the older value is gone
    assert (cache.held, cache.peek("a")) == (1, None)
