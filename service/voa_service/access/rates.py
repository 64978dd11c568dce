"""Calls per key and time, counted in the memory of this process: N processes together allow up to N times as many.

Calls without a valid key are counted by their origin. Nobody guesses 256 bits, but each refusal costs a response and a
line in the log. A valid key is accepted from every origin: else a stranger could lock out all who share its address.
"""

import ipaddress
import math
import threading
import time

import structlog
from limits import RateLimitItem, parse
from limits.storage import Storage
from limits.strategies import FixedWindowRateLimiter

from voa_service.access.callers import Caller
from voa_service.access.roles import Call
from voa_service.failures import TooManyRequests, TooManyWithoutKey

_LONGEST_RETRY_S = 3600
_MOST_ORIGINS = 1_024
"""Origins of refused calls that are counted apart; beyond, those that are new are counted together."""
_OTHERS = "others"
_GROUP = 10
"""Number of origins whose whole rate a group of origins has together."""


class Rates:
    """The rates of all keys; callers of a service without keys are not counted.

    Args:
        calls: most calls of a key, as in "200/second".
        heavy: most calls of a key that may take long, such as rankings and uploads, as in "300/minute".
        refused: most calls without a valid key from an origin, as in "120/minute"; more of them are refused shorter.
    """

    def __init__(self, calls: str, heavy: str, refused: str) -> None:
        self._calls = parse(calls)
        self._heavy = parse(heavy)
        self._refused = parse(refused)
        self._grouped = type(self._refused)(_GROUP * self._refused.amount, self._refused.multiples)
        self._limiter = FixedWindowRateLimiter(_Counters())
        self._origins = _Counters()
        self._refusals = FixedWindowRateLimiter(self._origins)

    def count(self, caller: Caller) -> None:
        """Count a call of a key, whether it may make the call or not.

        Raises:
            TooManyRequests: the key has made too many.
        """
        if caller.key is not None:
            self._count(self._calls, "calls", caller.name, caller.key)

    def count_heavy(self, caller: Caller, call: Call) -> None:
        """Count a call of a key that may make it, if it is a heavy one.

        Raises:
            TooManyRequests: the key has made too many.
        """
        if caller.key is not None and call.heavy:
            self._count(self._heavy, "rankings and other heavy calls", caller.name, caller.key)

    def count_refused(self, origin: str, group: str | None = None) -> None:
        """Count a call without a valid key; the first one too many of a period is logged.

        Args:
            origin: address, or name on Zenoh.
            group: of origins, which together have ten times the rate of an origin; None: of none.

        Raises:
            TooManyWithoutKey: too many had this origin, or this group of origins.
        """
        self._count_origin(self._refused, network_of(origin) if self._origins.has_room(_MOST_ORIGINS) else _OTHERS)
        if group is not None:
            self._count_origin(self._grouped, group)

    def _count_origin(self, rate: RateLimitItem, counted: str) -> None:
        if self._refusals.hit(rate, counted):
            return
        if self._origins.get(rate.key_for(counted)) == rate.amount + 1:
            structlog.get_logger("voa").warning("many calls without a valid key", origin=counted, more_than=str(rate))
        seconds = self._left(self._refusals, rate, counted)
        raise TooManyWithoutKey(
            f"more than {rate.amount} calls without a valid key per {_period(rate)} came from {counted}: send a key, "
            f"or try again in {seconds} s",
            {"Retry-After": str(seconds)},
        )

    def _count(self, rate: RateLimitItem, what: str, name: str, key: str) -> None:
        if self._limiter.hit(rate, what, key):
            return
        seconds = self._left(self._limiter, rate, what, key)
        raise TooManyRequests(
            f"the key {name!r} may make {rate.amount} {what} per {_period(rate)}: try again in {seconds} s",
            {"Retry-After": str(seconds)},
        )

    @staticmethod
    def _left(limiter: FixedWindowRateLimiter, rate: RateLimitItem, *counted: str) -> int:
        """Return the time until a counter begins again, whole seconds."""
        left = limiter.get_window_stats(rate, *counted).reset_time - time.monotonic()
        return max(1, min(math.ceil(left), _LONGEST_RETRY_S))


def _period(rate: RateLimitItem) -> str:
    name = rate.GRANULARITY.name
    return name if rate.multiples == 1 else f"{rate.multiples} {name}s"


def network_of(origin: str) -> str:
    """Return the network of an IPv6 address, since a host has all addresses of its own; other origins unchanged."""
    try:
        address = ipaddress.ip_address(origin)
    except ValueError:
        return origin
    if isinstance(address, ipaddress.IPv4Address):
        return origin
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ipaddress.IPv6Network((address, 64), strict=False))


class _Counters(Storage):
    """Counters in memory for fixed windows; the library's own start a thread at every hit after a pause.

    Keys have two counters each, of which none needs to be removed; of origins, `has_room` removes those that are over.
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

    def has_room(self, most: int) -> bool:
        """Return True if there are fewer counters than so many, once those whose window is over are removed."""
        if len(self._counters) < most:
            return True
        now = time.monotonic()
        with self._lock:
            self._counters = {key: kept for key, kept in self._counters.items() if kept[1] > now}
            return len(self._counters) < most

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
