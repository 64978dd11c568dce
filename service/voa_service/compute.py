"""Work off the event loop: bounded queues in front of worker threads, and threads for the parts of one ranking."""

import asyncio
import math
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import anyio
import anyio.to_thread

from voa_service.failures import OVERLOADED, Failure

T = TypeVar("T")
A = TypeVar("A")
B = TypeVar("B")


class WorkQueue:
    """At most `workers` calls at a time, at most `waiting` in line; one more is refused at once.

    A call whose caller has gone still counts until it ends.
    """

    def __init__(self, name: str, workers: int, waiting: int) -> None:
        self._name = name
        self._limiter = anyio.CapacityLimiter(workers)
        self._most = workers + waiting
        self._calls: set[asyncio.Future[Any]] = set()

    @property
    def inside(self) -> int:
        """Calls under way or in line."""
        return len(self._calls)

    async def run(self, work: Callable[[], T]) -> T:
        """`work()`, in a worker thread.

        Raises:
            Failure: overloaded; nothing was done.
        """
        if self.inside >= self._most:
            raise Failure(
                OVERLOADED,
                f"{self.inside} {self._name} requests are under way or waiting already: try again in a second",
                headers={"Retry-After": str(max(1, math.ceil(self._most / 64)))},
            )
        call = asyncio.ensure_future(anyio.to_thread.run_sync(work, limiter=self._limiter))
        self._calls.add(call)
        call.add_done_callback(self._ended)
        # A thread cannot be stopped: a caller that is cancelled leaves, its call keeps its place and its worker.
        return await asyncio.shield(call)

    def _ended(self, call: asyncio.Future[Any]) -> None:
        self._calls.discard(call)
        if not call.cancelled():
            call.exception()  # seen, even if the caller has gone


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
