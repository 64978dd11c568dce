"""Work off the event loop: bounded queues in front of worker threads, and threads for the parts of one ranking."""

import asyncio
import contextvars
import math
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

from voa_service.failures import OVERLOADED, Failure

T = TypeVar("T")
A = TypeVar("A")
B = TypeVar("B")


class WorkQueue:
    """At most `workers` calls at a time, at most `waiting` in line; one more is refused at once.

    A call whose caller has gone still counts until it ends: a thread cannot be stopped.
    """

    def __init__(self, name: str, workers: int, waiting: int) -> None:
        self._name = name
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix=f"voa-{name}")
        self._most = workers + waiting
        self._inside = 0
        self._lock = threading.Lock()

    @property
    def inside(self) -> int:
        """Calls under way or in line."""
        return self._inside

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """`work()`, in a worker thread, with the caller's log context.

        Raises:
            Failure: overloaded; nothing was done.
        """
        with self._lock:
            if self._inside >= self._most:
                raise Failure(
                    OVERLOADED,
                    f"{self._inside} {self._name} requests are under way or waiting already: try again in a second",
                    headers={"Retry-After": str(max(1, math.ceil(self._most / 64)))},
                )
            self._inside += 1
        try:
            call = self._pool.submit(contextvars.copy_context().run, work)
        except BaseException:
            self._ended()
            raise
        call.add_done_callback(self._ended)
        return call

    async def run(self, work: Callable[[], T]) -> T:
        """The same, awaited; a caller that is cancelled leaves, its call keeps its place."""
        call = asyncio.wrap_future(self.submit(work))
        call.add_done_callback(_seen)
        return await asyncio.shield(call)

    def close(self) -> None:
        """End the threads when what is under way has ended; what has not begun is dropped."""
        self._pool.shutdown(cancel_futures=True)

    def _ended(self, _: object = None) -> None:
        with self._lock:
            self._inside -= 1


def _seen(call: asyncio.Future[Any]) -> None:
    """An error is not lost on a caller that has gone."""
    if not call.cancelled():
        call.exception()


class Threads:
    """A `voa_core.ranking.Spread` over threads: the kernels and BLAS release the GIL."""

    def __init__(self, workers: int) -> None:
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="voa-core")

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterable[B]:
        """The results, in the order of the items."""
        return self._pool.map(function, items)

    def close(self) -> None:
        """End the threads; what has not begun is dropped."""
        self._pool.shutdown(cancel_futures=True)
