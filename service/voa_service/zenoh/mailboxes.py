"""Bounded queues of samples, one for each sender: in order for a sender, in parallel for several senders."""

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Generic, TypeVar

T = TypeVar("T")

MOST_WAITING = 16_384
"""Samples that may wait in all boxes together."""
MOST_WAITING_BYTES = 64 * 2**20
"""Bytes of samples that may wait in all boxes together."""
_SHARE = 4
"""Each box may hold 1/_SHARE of the items and bytes that may wait, so that a fast sender leaves room for others."""


class Mailboxes(Generic[T]):
    """A box of waiting items for each name; the items of a box are handled one after another.

    Args:
        work: called with each item in a worker thread; must not raise.
        workers: number of threads.
        most_items: items that may wait in all boxes together.
        most_bytes: sum of the sizes of items that may wait in all boxes together.
    """

    def __init__(self, work: Callable[[T], None], workers: int, most_items: int, most_bytes: int) -> None:
        self._work = work
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="voa-scans")
        self._most_items = most_items
        self._most_bytes = most_bytes
        self._items = self._bytes = 0
        self._boxes: dict[str, deque[tuple[T, int]]] = {}
        self._sizes: dict[str, int] = {}
        self._lock = threading.Lock()
        self._empty = threading.Condition(self._lock)
        self._closed = False

    @property
    def waiting(self) -> int:
        """Number of items in all boxes."""
        return self._items

    def put(self, name: str, item: T, size: int) -> bool:
        """Add an item to a box, from any thread; returns False where there is no room for it."""
        with self._lock:
            if self._closed or self._items >= self._most_items or self._bytes + size > self._most_bytes:
                return False
            box, held = self._boxes.get(name), self._sizes.get(name, 0)
            if box is not None and (_SHARE * len(box) >= self._most_items or _SHARE * held > self._most_bytes):
                return False
            self._items += 1
            self._bytes += size
            self._sizes[name] = held + size
            if box is not None:
                box.append((item, size))
                return True
            self._boxes[name] = deque([(item, size)])
            self._pool.submit(self._next, name)
            return True

    def drain(self, seconds: float) -> int:
        """Wait until all items are handled, at most so many seconds; returns how many are left."""
        with self._empty:
            self._empty.wait_for(lambda: self._items == 0, seconds)
            return self._items

    def close(self) -> None:
        """Drop the items that wait, and return when those under way are handled."""
        with self._lock:
            self._closed = True
        self._pool.shutdown(cancel_futures=True)

    def _next(self, name: str) -> None:
        """Handle the first item of a box, then queue the box again behind the others, so that none blocks them."""
        item, size = self._boxes[name][0]
        try:
            self._work(item)
        finally:
            with self._lock:
                box = self._boxes[name]
                box.popleft()
                self._items -= 1
                self._bytes -= size
                self._sizes[name] -= size
                if not self._items:
                    self._empty.notify_all()
                if not box:
                    del self._boxes[name], self._sizes[name]
                elif not self._closed:
                    self._pool.submit(self._next, name)
