"""Gathers the work of many threads in groups: what waits while one group is done makes up the next one.

A thread that finds nobody at work does its own item at once, as a group of one, so that nobody waits for company. The
first of those that wait does the next group for all of them, while the others sleep until their item is done.
"""

import threading
from collections.abc import Callable, Hashable, Sequence
from typing import Generic, Protocol, TypeVar

from voa_store.errors import Busy


class Named(Protocol):
    """Item of a group."""

    @property
    def id(self) -> Hashable:
        """Name of what the item works on: items of one name are done one after the other, in different groups."""


T = TypeVar("T", bound=Named)


class Latch:
    """Signal that one thread waits for, and another gives once."""

    def __init__(self) -> None:
        self._closed = threading.Lock()
        self._closed.acquire()

    def wait(self, seconds: float | None = None) -> bool:
        """Wait for the signal; False: it was not given within so many seconds (None: no bound)."""
        return self._closed.acquire(timeout=-1 if seconds is None else seconds)

    def open(self) -> None:
        """Give the signal."""
        self._closed.release()


class _Member(Generic[T]):
    """An item, and the thread that waits for it.

    Attributes:
        item: to be done.
        latch: wakes the thread.
        taken: True once a group has the item, whether this thread or another one does that group.
        leads: True if this thread does the group.
        error: that ended the group before it was done; None: there was none.
    """

    def __init__(self, item: T) -> None:
        self.item = item
        self.latch = Latch()
        self.taken = self.leads = False
        self.error: BaseException | None = None


class Groups(Generic[T]):
    """Items that are done in groups, one group at a time.

    Args:
        do: does a group, in the thread of one of its items; each item then has its own result.
        most: items of a group.
        patience_s: seconds for which an item waits for its group to begin.
    """

    def __init__(self, do: Callable[[Sequence[T]], None], most: int, patience_s: float) -> None:
        self._do = do
        self._most = most
        self._patience_s = patience_s
        self._lock = threading.Lock()
        self._working = False
        self._waiting: list[_Member[T]] = []

    def join(self, item: T) -> None:
        """Have an item done, by this thread or by another one, and return after that.

        Raises:
            Busy: others were at work for too long.
        """
        member = _Member(item)
        with self._lock:
            if self._working:
                self._waiting.append(member)
            else:
                self._working = member.leads = True
        if not member.leads:
            self._wait(member)
        if member.leads:
            self._lead(member)
        elif member.error is not None:
            raise member.error

    def _wait(self, member: _Member[T]) -> None:
        """Wait until an item is done, or its thread has to do a group."""
        if member.latch.wait(self._patience_s):
            return
        with self._lock:
            if not member.taken:
                self._waiting.remove(member)
                raise Busy("too many requests wait for the database: try again")
        member.latch.wait()

    def _lead(self, first: _Member[T]) -> None:
        """Do the group of an item; then the first of those that still wait does the next one."""
        with self._lock:
            group = [first, *self._companions(first)]
        try:
            self._do([member.item for member in group])
        except BaseException as error:
            for member in group:
                member.error = error
            raise
        finally:
            with self._lock:
                following = self._waiting.pop(0) if self._waiting else None
                if following is not None:
                    following.taken = following.leads = True
                self._working = following is not None
            for member in [*([] if following is None else [following]), *group[1:]]:
                member.latch.open()

    def _companions(self, first: _Member[T]) -> list[_Member[T]]:
        """Take those that wait, the first of each id and no more than a group has, away from the others."""
        taken, left, ids = list[_Member[T]](), list[_Member[T]](), {first.item.id}
        for member in self._waiting:
            if len(taken) + 1 < self._most and member.item.id not in ids:
                ids.add(member.item.id)
                member.taken = True
                taken.append(member)
            else:
                left.append(member)
        self._waiting = left
        return taken
