"""Early end of a program by Ctrl-C or after a time, in order and without fail.

A signal handler raises an exception, which may come up anywhere, also in a callback or destructor of a library that
swallows it. So the reason is kept as well, and checked between two pieces of work.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class TimeIsUp(Exception):
    """The time of the program is over."""


class Interruption:
    """Record of a signal that ends the program."""

    def __init__(self) -> None:
        self._reason: BaseException | None = None

    def check(self) -> None:
        """Raise `KeyboardInterrupt` or `TimeIsUp` if the signal for it has arrived."""
        if self._reason is not None:
            raise self._reason

    def on_interrupt(self, _number: int, _frame: FrameType | None) -> None:
        """Handle SIGINT: keep and raise `KeyboardInterrupt`."""
        self._reason = KeyboardInterrupt()
        raise self._reason

    def on_alarm(self, _number: int, _frame: FrameType | None) -> None:
        """Handle SIGALRM: keep and raise `TimeIsUp`."""
        self._reason = TimeIsUp()
        raise self._reason


@contextmanager
def interruptible(seconds: float | None) -> Iterator[Interruption]:
    """Raise `KeyboardInterrupt` on Ctrl-C, and `TimeIsUp` after so many seconds, in the body of the `with` statement.

    Outside of the main thread nothing is raised, because only that one receives signals.
    """
    interruption = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interruption
        return
    handlers = {signal.SIGINT: interruption.on_interrupt, signal.SIGALRM: interruption.on_alarm}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    signal.setitimer(signal.ITIMER_REAL, seconds or 0.0)
    try:
        yield interruption
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)
