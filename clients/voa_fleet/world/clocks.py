"""Time of the simulation: virtual, as fast as the computer allows, or real."""

import time
from dataclasses import dataclass
from typing import Protocol


class Clock(Protocol):
    """A clock by which a simulation runs."""

    def now_s(self) -> float:
        """Return the seconds since an arbitrary moment."""

    def sleep(self, seconds: float) -> None:
        """Let time pass."""


@dataclass
class VirtualClock:
    """A clock that advances only by `sleep`, which returns at once."""

    seconds: float = 0.0

    def now_s(self) -> float:
        """Return the seconds slept so far."""
        return self.seconds

    def sleep(self, seconds: float) -> None:
        """Advance the clock."""
        self.seconds += seconds


class RealClock:
    """The computer's monotonic clock.

    A sleep ends when it would have ended if all sleeps before it had been exact. So work between two sleeps does not
    slow the simulation down, as long as it takes less time than the sleep.
    """

    def __init__(self) -> None:
        self._due = time.monotonic()

    def now_s(self) -> float:
        """Return the monotonic time, seconds."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Block until the time is over."""
        # Time that passed without a sleep is not made up for: the simulation would race.
        self._due = max(self._due, time.monotonic() - seconds) + seconds
        time.sleep(max(0.0, self._due - time.monotonic()))
