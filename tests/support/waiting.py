"""Waiting for conditions, never for time."""

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

SECONDS = 30.0
_LOOK_SECONDS = 0.005


def wait_for(condition: Callable[[], T], what: str, seconds: float = SECONDS) -> T:
    """What `condition` gives as soon as that is true; fails after `seconds`."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, f"waited {seconds:g} s for {what}"
        time.sleep(_LOOK_SECONDS)
    return found
