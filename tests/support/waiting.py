"""Wait for conditions, not for a time."""

import time
from collections.abc import Callable
from typing import TypeVar

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
