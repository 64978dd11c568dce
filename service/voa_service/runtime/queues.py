"""Work off the event loop: bounded queues in front of worker threads, and threads for the parts of one ranking."""

import asyncio
import contextvars
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from voa_service.failures import NotReady, Overloaded
from voa_service.runtime.workers import Workers

T = TypeVar("T")
A = TypeVar("A")
B = TypeVar("B")
Check = Callable[[], None]
"""Returns while the work is still wanted, else raises; called between the parts of long work."""

_LATEST = 32
_LONGEST_RETRY_S = 600
_END_SECONDS = 5.0


class Cancelled(Exception):
    """Nobody waits for the work any more."""


@dataclass(eq=False)
class _Shared:
    """One call and how many wait for it."""

    future: Future[Any]
    waiters: int = 0


class WorkQueue:
    """A line in front of `workers` threads in which at most `waiting` calls wait; one more is refused at once.

    A call whose caller has gone still counts until it ends, for a thread cannot be stopped; one that is shared
    (`share`) leaves the line when its last caller goes, and ends at its next check where it has begun.
    """

    def __init__(self, name: str, workers: int, waiting: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._name = name
        self._pool = Workers(name, workers)
        self._workers = workers
        self._most = workers + waiting
        self._clock = clock
        self._begun: dict[object, float] = {}
        self._latest: deque[float] = deque(maxlen=_LATEST)
        self._inside = 0
        self._shared: dict[Hashable, _Shared] = {}
        self._ends_at = math.inf
        self._lock = threading.RLock()  # a future that is cancelled under it calls back at once

    @property
    def inside(self) -> int:
        """Calls under way or in line."""
        return self._inside

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Call `work` in a worker thread, with the caller's log context.

        Raises:
            Failure: overloaded; nothing was done.
        """
        with self._lock:
            if self._inside >= self._most:
                seconds = self.retry_after_s()
                raise Overloaded(
                    f"{self._inside} {self._name} requests are under way or waiting already: try again in {seconds} s",
                    headers={"Retry-After": str(seconds)},
                )
            self._inside += 1
        call: Future[T] = Future()
        call.add_done_callback(self._left)
        context = contextvars.copy_context()
        self._pool.submit(call, lambda: context.run(self._timed, work))
        return call

    async def run(self, work: Callable[[], T]) -> T:
        """Call `work` in a worker thread and await it; a caller that is cancelled leaves, its call keeps its place."""
        call = asyncio.wrap_future(self.submit(work))
        call.add_done_callback(_seen)
        return await asyncio.shield(call)

    async def share(self, key: Hashable, work: Callable[[Check], T]) -> T:
        """Await the call of `key`, one for all who ask while it is in line or under way.

        Args:
            key: equal for calls with equal results.
            work: is given a check, which raises `Cancelled` once every caller has left (was cancelled itself), and
                `Failure` once the service ends.

        Raises:
            Failure: overloaded; nothing was done.
        """
        with self._lock:
            call = self._shared.get(key)
            if call is None:
                call = self._begin(key, work)
            call.waiters += 1
        waiting = asyncio.wrap_future(call.future)
        waiting.add_done_callback(_seen)
        try:
            return await asyncio.shield(waiting)
        finally:
            self._leave(key, call)

    def check(self) -> None:
        """Return while the service goes on.

        Raises:
            Failure: it has been ending for longer than calls were given.
        """
        if self._clock() >= self._ends_at:
            raise NotReady("the service is ending: ask again", {"Retry-After": "2"})

    def end_in(self, seconds: float) -> None:
        """Let `check` fail after some seconds: in a signal handler too, so without a lock."""
        self._ends_at = min(self._ends_at, self._clock() + seconds)

    def close(self, seconds: float = _END_SECONDS) -> None:
        """Drop what has not begun, and wait at most so long for what has; a thread that goes on stops no exit."""
        self.end_in(0.0)
        self._pool.close(seconds)

    def retry_after_s(self) -> int:
        """Estimate in how many seconds a call could begin: the mean duration of the latest, by the line per worker.

        Before any call has ended, those under way count with their duration so far.
        """
        with self._lock:
            now = self._clock()
            durations = list(self._latest) or [now - begun for begun in self._begun.values()] or [0.0]
            line = self._inside / self._workers
        seconds = math.ceil(sum(durations) / len(durations) * line)
        return max(1, min(seconds, _LONGEST_RETRY_S))

    def _begin(self, key: Hashable, work: Callable[[Check], Any]) -> _Shared:
        """Put a shared call in line; under the lock."""

        def check() -> None:
            self.check()
            if call.waiters == 0:
                raise Cancelled

        # Its waiter is counted before the lock is released, and the work looks only after the lock was free once.
        def begun() -> Any:
            with self._lock:
                pass
            check()
            return work(check)

        call = _Shared(self.submit(begun))
        self._shared[key] = call
        return call

    def _leave(self, key: Hashable, call: _Shared) -> None:
        with self._lock:
            call.waiters -= 1
            last = call.waiters == 0
            if (last or call.future.done()) and self._shared.get(key) is call:
                del self._shared[key]
        if last:
            call.future.cancel()

    def _timed(self, work: Callable[[], T]) -> T:
        token, begun = object(), self._clock()
        with self._lock:
            self._begun[token] = begun
        try:
            done = work()
        finally:
            with self._lock:
                del self._begun[token]
        with self._lock:  # only what was done: a failure at once says nothing about the next call
            self._latest.append(self._clock() - begun)
        return done

    def _left(self, _: object = None) -> None:
        with self._lock:
            self._inside -= 1


def _seen(call: asyncio.Future[Any]) -> None:
    """Look at the error of a call whose caller has gone, so that none is reported as lost."""
    if not call.cancelled():
        call.exception()


class Threads:
    """A `voa_core.ranking.OrderedMap` over threads: the kernels and BLAS release the GIL."""

    def __init__(self, workers: int) -> None:
        self._pool = Workers("core", workers)

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterable[B]:
        """Yield the results in the order of the items; after an error what has not begun is dropped."""
        calls: list[Future[B]] = []
        try:
            for item in items:
                calls.append(Future())
                self._pool.submit(calls[-1], partial(function, item))
            for call in calls:
                yield call.result()
        finally:
            for call in calls:
                call.cancel()

    def close(self, seconds: float = _END_SECONDS) -> None:
        """Drop what has not begun, and wait at most so long for what has."""
        self._pool.close(seconds)
