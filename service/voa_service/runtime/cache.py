"""What can be computed again, kept while there is room: cuts, predictions and weights, by content."""

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
        """In bytes."""


S = TypeVar("S", bound=Sized)

_CHECK_SECONDS = 0.2


def _wanted() -> None:
    """Find every value wanted."""


def _result(pending: "Future[Any]", check: Check) -> Any:
    """The result of another thread's computation, as long as `check` lets this one wait."""
    while True:
        try:
            return pending.result(_CHECK_SECONDS)
        except TimeoutError:
            if pending.done():
                return pending.result()
        check()


class Cache:
    """Least recently used go first once the values hold more than `budget` bytes.

    Each value is computed once even if several threads ask for it at the same time; where the one that computes is
    cancelled, another that waits takes over. A value that alone exceeds the budget is handed out and not kept.
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
        """The value of `key`, from `make` where it is not there; `check` ends a wait for another thread's `make`."""
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
                check()  # it was the other one that nobody waits for; else this one
        return self._make(key, make, mine)

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

    def _keep(self, key: Hashable, value: Sized) -> None:
        if value.nbytes > self.budget:
            return
        self._values[key] = value
        self._held += value.nbytes
        while self._held > self.budget:
            _, dropped = self._values.popitem(last=False)
            self._held -= dropped.nbytes
