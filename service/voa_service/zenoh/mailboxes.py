"""Samples waiting to be worked on: in order for each sender, side by side for several, never without bound."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Generic, TypeVar

T = TypeVar("T")


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
        self._lock = threading.Lock()
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
            self._items += 1
            self._bytes += size
            box = self._boxes.get(name)
            if box is not None:
                box.append((item, size))
                return True
            self._boxes[name] = deque([(item, size)])
            self._pool.submit(self._next, name)
            return True

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
                if not box:
                    del self._boxes[name]
                elif not self._closed:
                    self._pool.submit(self._next, name)


class Later(Generic[T]):
    """Items that are handed on after a while, in order.

    Args:
        seconds: the while.
        hand_on: called with each item, in a thread of its own; must not raise.
        most: items that wait.
    """

    def __init__(self, seconds: float, hand_on: Callable[[T], None], most: int) -> None:
        self._seconds = seconds
        self._hand_on = hand_on
        self._items: deque[tuple[float, T]] = deque(maxlen=most)
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="voa-later")
        self._thread.start()

    def put(self, item: T) -> None:
        """Wait with an item; beyond the bound the oldest one is forgotten."""
        with self._changed:
            self._items.append((time.monotonic() + self._seconds, item))
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
                    return self._items.popleft()[1]
                self._changed.wait(left)
        return None
