"""Work off the event loop: bounded queues in front of worker threads, and threads for the parts of one ranking."""

import asyncio
import contextvars
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from voa_service.failures import NotReady, Overloaded
from voa_service.runtime.workers import Workers

T = TypeVar("T")
A = TypeVar("A")
B = TypeVar("B")
Check = Callable[[], None]
"""Function that long work calls between its parts; it raises once the work is no longer wanted."""

_LATEST = 32
_LONGEST_RETRY_S = 600
_END_SECONDS = 5.0


class Cancelled(Exception):
    """Long work was given up, because no caller waits for its result any more."""


@dataclass(eq=False)
class _Shared:
    """A shared call, and the number of callers that wait for it."""

    future: Future[Any]
    waiters: int = 0


class WorkQueue:
    """A queue of at most `waiting` calls in front of `workers` threads; one more call is refused at once.

    A call whose caller has gone still counts until it ends, for a thread cannot be stopped. A shared call (`share`)
    leaves the queue when its last caller goes; once begun, it ends at its next check.
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
        """Number of calls that are under way or waiting."""
        return self._inside

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Call `work` in a worker thread, with the caller's log context.

        Raises:
            Failure: the queue is full; `work` is not called.
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
        """Call `work` in a worker thread and await its result; the call goes on where its caller is cancelled."""
        loop = asyncio.get_running_loop()
        result: asyncio.Future[T] = loop.create_future()
        self.submit(work).add_done_callback(partial(_hand_over, loop, result))
        return await result

    async def share(self, key: Hashable, work: Callable[[Check], T]) -> T:
        """Await the call with a key: callers with equal keys share one call while it waits or is under way.

        Args:
            key: equal for calls with equal results.
            work: receives a check, which raises `Cancelled` once all callers have been cancelled, and `Failure` once
                the service stops.

        Raises:
            Failure: the queue is full; `work` is not called.
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
        """Return at once while the service runs.

        Raises:
            Failure: the service stops, and the time that calls were given is over.
        """
        if self._clock() >= self._ends_at:
            raise NotReady("the service is stopping: try again", {"Retry-After": "2"})

    def end_in(self, seconds: float) -> None:
        """Let `check` fail after some seconds; takes no lock, for a signal handler may call it."""
        self._ends_at = min(self._ends_at, self._clock() + seconds)

    def close(self, seconds: float = _END_SECONDS) -> None:
        """Drop the calls that wait, and wait at most so many seconds for those under way; they do not delay an exit."""
        self.end_in(0.0)
        self._pool.close(seconds)

    def retry_after_s(self) -> int:
        """Estimate in how many seconds a new call could begin: mean duration of the last calls times queue per worker.

        Before any call has ended, the calls under way count with their duration so far.
        """
        with self._lock:
            now = self._clock()
            durations = list(self._latest) or [now - begun for begun in self._begun.values()] or [0.0]
            calls_per_worker = self._inside / self._workers
        seconds = math.ceil(sum(durations) / len(durations) * calls_per_worker)
        return max(1, min(seconds, _LONGEST_RETRY_S))

    def _begin(self, key: Hashable, work: Callable[[Check], Any]) -> _Shared:
        """Queue a shared call; the caller holds the lock."""

        def check() -> None:
            self.check()
            if call.waiters == 0:
                raise Cancelled

        # The first caller is counted under the lock: the work checks for callers only after the lock was free once.
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
        with self._lock:  # only calls that ended well: a quick failure says nothing about the next call
            self._latest.append(self._clock() - begun)
        return done

    def _left(self, _: object = None) -> None:
        with self._lock:
            self._inside -= 1


def _hand_over(loop: asyncio.AbstractEventLoop, result: asyncio.Future[T], call: Future[T]) -> None:
    """Give the outcome of a call, in the thread where it ended, to a future of an event loop that may be closed."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(_set, result, call)


def _set(result: asyncio.Future[T], call: Future[T]) -> None:
    """Set the result of a call, unless its caller has gone."""
    if result.done():
        return
    if call.cancelled():
        result.cancel()
        return
    error = call.exception()
    if error is None:
        result.set_result(call.result())
    else:
        result.set_exception(error)


def _seen(call: asyncio.Future[Any]) -> None:
    """Retrieve the error of a call whose caller has gone, so that asyncio does not report it as lost."""
    if not call.cancelled():
        call.exception()


class Threads:
    """A `voa_core.ranking.OrderedMap` over threads: the kernels and BLAS release the GIL."""

    def __init__(self, workers: int) -> None:
        self._pool = Workers("core", workers)

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterable[B]:
        """Yield the results in the order of the items; after an error, calls that have not begun are dropped."""
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
        """Drop the calls that wait, and wait at most so many seconds for those under way."""
        self._pool.close(seconds)
