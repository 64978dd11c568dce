"""Calls per key and time, counted in the memory of this process: N processes together allow up to N times as many."""

import math
import threading
import time

from limits import RateLimitItem, parse
from limits.storage import Storage
from limits.strategies import FixedWindowRateLimiter

from voa_service.access.callers import Caller
from voa_service.access.roles import Call
from voa_service.failures import TooManyRequests

_LONGEST_RETRY_S = 3600


class Rates:
    """The rates of all keys; callers of a service without keys are not counted.

    Args:
        calls: most calls of a key, as in "200/second".
        heavy: most calls of a key that may take long, such as rankings and uploads, as in "300/minute".
    """

    def __init__(self, calls: str, heavy: str) -> None:
        self._calls = parse(calls)
        self._heavy = parse(heavy)
        self._limiter = FixedWindowRateLimiter(_Counters())

    def count(self, caller: Caller, call: Call) -> None:
        """Count a call.

        Raises:
            TooManyRequests: the key has made too many.
        """
        if caller.key is None:
            return
        self._count(self._calls, "calls", caller)
        if call.heavy:
            self._count(self._heavy, "rankings and other heavy calls", caller)

    def _count(self, rate: RateLimitItem, what: str, caller: Caller) -> None:
        key = caller.key or ""
        if self._limiter.hit(rate, what, key):
            return
        left = self._limiter.get_window_stats(rate, what, key).reset_time - time.monotonic()
        seconds = max(1, min(math.ceil(left), _LONGEST_RETRY_S))
        raise TooManyRequests(
            f"the key {caller.name!r} may make {rate.amount} {what} per {_period(rate)}: try again in {seconds} s",
            {"Retry-After": str(seconds)},
        )


def _period(rate: RateLimitItem) -> str:
    name = rate.GRANULARITY.name
    return name if rate.multiples == 1 else f"{rate.multiples} {name}s"


class _Counters(Storage):
    """Counters in memory for fixed windows; the library's own start a thread at every hit after a pause.

    There are two counters for each key that was ever used, so that none needs to be removed.
    """

    STORAGE_SCHEME = None

    def __init__(self) -> None:
        super().__init__()
        self._counters: dict[str, tuple[int, float]] = {}
        self._lock = threading.Lock()

    @property
    def base_exceptions(self) -> type[Exception]:
        """Class of the errors of this storage, which has none of its own."""
        return ValueError

    def incr(self, key: str, expiry: float, amount: int = 1) -> int:
        """Add to a counter, which begins again when its window is over; returns the sum."""
        now = time.monotonic()
        with self._lock:
            count, ends = self._counters.get(key, (0, 0.0))
            if ends <= now:
                count, ends = 0, now + expiry
            self._counters[key] = (count + amount, ends)
        return count + amount

    def get(self, key: str) -> int:
        """Return a counter."""
        count, ends = self._counters.get(key, (0, 0.0))
        return count if ends > time.monotonic() else 0

    def get_expiry(self, key: str) -> float:
        """Return the time at which the window of a counter ends, by a clock that never goes back, seconds."""
        return self._counters.get(key, (0, time.monotonic()))[1]

    def check(self) -> bool:
        """Return True: memory is always there."""
        return True

    def reset(self) -> int | None:
        """Remove all counters; returns how many there were."""
        with self._lock:
            count = len(self._counters)
            self._counters.clear()
        return count

    def clear(self, key: str) -> None:
        """Remove a counter."""
        with self._lock:
            self._counters.pop(key, None)
