"""Work that this replica does after a delay, in case the replica responsible for it has not done it by then."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from voa_service.zenoh.mailboxes import Mailboxes

T = TypeVar("T")


class Deferred(Generic[T]):
    """Items that are handed on after a delay, in their order.

    Args:
        seconds: delay of each item.
        hand_on: called with each item that is due, in a thread of its own; must not raise.
        most: items that may wait.
        most_bytes: sum of the sizes of items that may wait.
    """

    def __init__(self, seconds: float, hand_on: Callable[[T], None], most: int, most_bytes: int) -> None:
        self._seconds = seconds
        self._hand_on = hand_on
        self._most = most
        self._most_bytes = most_bytes
        self._bytes = 0
        self._items: deque[tuple[float, T, int]] = deque()
        self._changed = threading.Condition(threading.RLock())
        self._is_handing_on = False
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="voa-deferred")
        self._thread.start()

    def put(self, item: T, size: int) -> int:
        """Add an item; returns how many of the oldest items were dropped to stay within the bounds."""
        dropped = 0
        with self._changed:
            self._items.append((time.monotonic() + self._seconds, item, size))
            self._bytes += size
            while len(self._items) > self._most or self._bytes > self._most_bytes:
                self._bytes -= self._items.popleft()[2]
                dropped += 1
            self._changed.notify_all()
        return dropped

    def hasten(self) -> None:
        """Hand on the items that wait now without further delay; from any thread, returns at once."""
        with self._changed:
            self._items = deque((0.0, item, size) for _, item, size in self._items)
            self._changed.notify_all()

    def drain(self, seconds: float) -> None:
        """Hand on every item without delay until none is left, at most for so many seconds."""
        end = time.monotonic() + seconds
        with self._changed:
            while (self._items or self._is_handing_on) and not self._closed and (left := end - time.monotonic()) > 0.0:
                if self._items and self._items[-1][0] > 0.0:  # it was added since
                    self.hasten()
                self._changed.wait(left)

    def close(self) -> None:
        """Drop the items that wait, and end the thread."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join()

    def _run(self) -> None:
        while (item := self._due()) is not None:
            self._hand_on(item)

    def _due(self) -> T | None:
        with self._changed:
            self._is_handing_on = False
            self._changed.notify_all()
            while not self._closed:
                left = None if not self._items else self._items[0][0] - time.monotonic()
                if left is not None and left <= 0:
                    _, item, size = self._items.popleft()
                    self._bytes -= size
                    self._is_handing_on = True
                    return item
                self._changed.wait(left)
        return None


def finish(boxes: Mailboxes[Any], deferred: Deferred[Any], left: Callable[[], float]) -> int:
    """Handle the items of boxes, what they have deferred, and what was deferred before; returns how many are left.

    Args:
        boxes: to which deferred items are handed on.
        deferred: items that wait in case another replica does not do them.
        left: returns the seconds that this may take.
    """
    boxes.drain(left())
    deferred.drain(left())
    return boxes.drain(left())
