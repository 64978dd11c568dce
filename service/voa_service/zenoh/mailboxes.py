"""Samples waiting to be worked on: in order for each sender, side by side for several, never without bound."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Generic, TypeVar

T = TypeVar("T")

MOST_WAITING = 16_384
MOST_WAITING_BYTES = 64 * 2**20
_SHARE = 4
"""No box may hold more than this part of everything: whoever sends too much is refused, and not the others."""


class Mailboxes(Generic[T]):
    """One box per name; the items of a box are worked on one after another.

    Args:
        work: called with each item in a worker thread; must not raise.
        workers: threads.
        most_items: in all boxes together.
        most_bytes: the same, by the sizes that are told.
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
        """Items in all boxes."""
        return self._items

    def put(self, name: str, item: T, size: int) -> bool:
        """Add an item to a box, from any thread; False: there is no room, nothing was done."""
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
        """Wait until everything was worked on, at most so long; how many items are left."""
        with self._empty:
            self._empty.wait_for(lambda: self._items == 0, seconds)
            return self._items

    def close(self) -> None:
        """End what is being worked on; what is waiting is dropped."""
        with self._lock:
            self._closed = True
        self._pool.shutdown(cancel_futures=True)

    def _next(self, name: str) -> None:
        """Work on the first item of a box, and get in line again: nobody's box holds up the others."""
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


class Later(Generic[T]):
    """Items that are handed on after a while, in order.

    Args:
        seconds: the while.
        hand_on: called with each item, in a thread of its own; must not raise.
        most: items that wait.
        most_bytes: the same, by the sizes that are told.
    """

    def __init__(self, seconds: float, hand_on: Callable[[T], None], most: int, most_bytes: int) -> None:
        self._seconds = seconds
        self._hand_on = hand_on
        self._most = most
        self._most_bytes = most_bytes
        self._bytes = 0
        self._items: deque[tuple[float, T, int]] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="voa-later")
        self._thread.start()

    def put(self, item: T, size: int) -> int:
        """Wait with an item; beyond the bounds the oldest ones are forgotten: how many."""
        forgotten = 0
        with self._changed:
            self._items.append((time.monotonic() + self._seconds, item, size))
            self._bytes += size
            while len(self._items) > self._most or self._bytes > self._most_bytes:
                self._bytes -= self._items.popleft()[2]
                forgotten += 1
            self._changed.notify()
        return forgotten

    def hasten(self) -> None:
        """Hand on what waits now without waiting longer; from any thread, and returns at once."""
        with self._changed:
            self._items = deque((0.0, item, size) for _, item, size in self._items)
            self._changed.notify()

    def close(self) -> None:
        """Forget what waits."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while (item := self._due()) is not None:
            self._hand_on(item)

    def _due(self) -> T | None:
        with self._changed:
            while not self._closed:
                left = None if not self._items else self._items[0][0] - time.monotonic()
                if left is not None and left <= 0:
                    _, item, size = self._items.popleft()
                    self._bytes -= size
                    return item
                self._changed.wait(left)
        return None
