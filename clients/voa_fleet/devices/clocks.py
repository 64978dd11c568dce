"""Time for the fleet: virtual, as fast as the computer allows, or real."""

import time
from dataclasses import dataclass
from typing import Protocol


class Clock(Protocol):
    """What tells the time and lets it pass."""

    def now_s(self) -> float:
        """Seconds since some moment."""

    def sleep(self, seconds: float) -> None:
        """Let time pass."""


@dataclass
class VirtualClock:
    """Time passes when somebody sleeps, and takes none."""

    seconds: float = 0.0

    def now_s(self) -> float:
        """Seconds slept so far."""
        return self.seconds

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        self.seconds += seconds


class RealClock:
    """The computer's monotonic clock.

    A sleep ends when it would have ended had all before it been exact: work between two sleeps does not slow the
    world down, as long as it is less than the sleep.
    """

    def __init__(self) -> None:
        self._due = time.monotonic()

    def now_s(self) -> float:
        """Monotonic seconds."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        # Time that passed while nobody slept is not caught up with.
        self._due = max(self._due, time.monotonic() - seconds) + seconds
        time.sleep(max(0.0, self._due - time.monotonic()))
