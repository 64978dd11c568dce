"""Findings of checks, and time limits for checks."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar

T = TypeVar("T")
State = Literal["ok", "warning", "wrong"]
"""State of a finding."""


@dataclass(frozen=True)
class Finding:
    """A line of the checklist: the result of a check, with advice.

    Attributes:
        check: name of the check.
        state: "ok"; "warning": probably a mistake; "wrong": something does not work.
        seen: observation, in a sentence.
        advice: action that a person should take; "" if nothing.
    """

    check: str
    state: State
    seen: str
    advice: str = ""


class TookTooLong(Exception):
    """A step of a check did not end within its time limit."""


class Budget:
    """Time budget of all checks together.

    Args:
        seconds: for all checks.
        clock: returns seconds that never go back.
    """

    def __init__(self, seconds: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._until = clock() + seconds

    def step(self, seconds: float) -> float:
        """Shorten a duration, in seconds, to the time that is left, but not below 0.05 s."""
        return max(0.05, min(seconds, self._until - self._clock()))

    def within(self, seconds: float, work: Callable[[], T]) -> T:
        """Run `work` in a thread, and return its result; a thread that does not end in time is abandoned.

        Raises:
            TookTooLong: it did not end within `seconds`.
            Exception: whatever `work` raises.
        """
        done: list[T] = []
        failed: list[Exception] = []

        def run() -> None:
            try:
                done.append(work())
            except Exception as error:  # raised again for the caller
                failed.append(error)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        thread.join(self.step(seconds))
        if failed:
            raise failed[0]
        if not done:
            raise TookTooLong
        return done[0]
