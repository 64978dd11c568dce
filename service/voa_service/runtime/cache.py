"""A cache of results that can be computed again, such as cuts, predictions and weights, bounded by their memory."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from typing import Any, Protocol, TypeVar, cast

from voa_service.runtime.queues import Cancelled, Check


class Sized(Protocol):
    """A value that knows how much memory it holds."""

    @property
    def nbytes(self) -> int:
        """Memory that the value holds, in bytes."""


S = TypeVar("S", bound=Sized)

_CHECK_SECONDS = 0.2


def _wanted() -> None:
    """Return at once: the default check, under which every value is still wanted."""


def _result(pending: "Future[Any]", check: Check) -> Any:
    """Wait for the result of another thread's computation, until `check` raises."""
    while True:
        try:
            return pending.result(_CHECK_SECONDS)
        except TimeoutError:
            if pending.done():
                return pending.result()
        check()


class Cache:
    """A cache that drops the least recently used values once all values hold more than `budget` bytes.

    Each value is computed once even if several threads request it at the same time; where the thread that computes is
    cancelled, another that waits takes over. A value that alone exceeds the budget is returned and not kept.
    """

    def __init__(self, budget: int) -> None:
        self.budget = budget
        self._values: OrderedDict[Hashable, Sized] = OrderedDict()
        self._pending: dict[Hashable, Future[Any]] = {}
        self._held = 0
        self._lock = threading.Lock()

    @property
    def held(self) -> int:
        """Bytes of the values that are kept."""
        return self._held

    def get(self, key: Hashable, make: Callable[[], S], check: Check = _wanted) -> S:
        """Return the value of a key, computed where the cache does not hold it.

        Args:
            key: names the value; equal keys must mean equal values.
            make: computes the value.
            check: called while this thread waits for another one that computes the value; ends the wait by raising.
        """
        while True:
            with self._lock:
                if key in self._values:
                    self._values.move_to_end(key)
                    return cast(S, self._values[key])
                pending = self._pending.get(key)
                if pending is None:
                    mine: Future[S] = Future()
                    self._pending[key] = mine
                    break
            try:
                return cast(S, _result(pending, check))
            except Cancelled:
                check()  # raises where this call was cancelled, and not only the other thread's
        return self._make(key, make, mine)

    def peek(self, key: Hashable) -> Sized | None:
        """Return the value of a key if the cache holds it, without any computation; None: it does not."""
        with self._lock:
            return self._values.get(key)

    def put(self, key: Hashable, value: Sized) -> None:
        """Keep the value of a key, in place of another one."""
        with self._lock:
            self._keep(key, value)

    def drop(self, key: Hashable) -> None:
        """Drop the value of a key, if the cache holds it."""
        with self._lock:
            self._drop(key)

    def _make(self, key: Hashable, make: Callable[[], S], mine: "Future[S]") -> S:
        try:
            value = make()
        except BaseException as error:
            with self._lock:
                del self._pending[key]
            mine.set_exception(error)
            raise
        with self._lock:
            del self._pending[key]
            self._keep(key, value)
        mine.set_result(value)
        return value

    def _drop(self, key: Hashable) -> None:
        dropped = self._values.pop(key, None)
        if dropped is not None:
            self._held -= dropped.nbytes

    def _keep(self, key: Hashable, value: Sized) -> None:
        self._drop(key)  # put by another thread while this one computed it
        if value.nbytes > self.budget:
            return
        self._values[key] = value
        self._held += value.nbytes
        while self._held > self.budget:
            _, dropped = self._values.popitem(last=False)
            self._held -= dropped.nbytes
