"""Wait for conditions, not for a time."""

import time
from collections.abc import Callable
from typing import TypeVar

from voa_client import TimedOutError

T = TypeVar("T")

SECONDS = 30.0
_POLL_SECONDS = 0.005


def wait_for(condition: Callable[[], T], what: str, seconds: float = SECONDS) -> T:
    """Return the value of `condition` as soon as it is true; fails after `seconds`."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, f"waited {seconds:g} s for {what}"
        time.sleep(_POLL_SECONDS)
    return value


def given_time(attempt: Callable[[float], T], seconds: float = 0.2) -> T:
    """Return the result of an attempt that is given `seconds`; on a busy machine, where it times out, twice as many."""
    while True:
        try:
            return attempt(seconds)
        except TimedOutError:
            seconds *= 2.0
            assert seconds < SECONDS, f"timed out within {seconds / 2.0:g} s"
