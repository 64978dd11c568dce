"""Interruption early, by a signal: in order, and for certain.

An exception that a signal raises may come up in the middle of anything, also where other people's code (a callback, a
destructor) swallows it. So the signal is kept too, and asked for between one piece of work and the next.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class TimeIsUp(Exception):
    """It is to end because its time is over."""


class Interruption:
    """Whether it is to end."""

    def __init__(self) -> None:
        self._reason: BaseException | None = None

    def check(self) -> None:
        """Raise `KeyboardInterrupt` or `TimeIsUp` if one of them has come up."""
        if self._reason is not None:
            raise self._reason

    def interrupted(self, _number: int, _frame: FrameType | None) -> None:
        """For SIGINT."""
        self._reason = KeyboardInterrupt()
        raise self._reason

    def rung(self, _number: int, _frame: FrameType | None) -> None:
        """For SIGALRM."""
        self._reason = TimeIsUp()
        raise self._reason


@contextmanager
def interruptible(seconds: float | None) -> Iterator[Interruption]:
    """Have Ctrl-C, and the end of so many seconds, raised in the body and kept; outside of the main thread never."""
    interruption = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interruption
        return
    handlers = {signal.SIGINT: interruption.interrupted, signal.SIGALRM: interruption.rung}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    signal.setitimer(signal.ITIMER_REAL, seconds or 0.0)
    try:
        yield interruption
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)
