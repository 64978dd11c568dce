"""What a check found, and time limits for checks."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar

from rich.markup import escape
from rich.table import Column, Table

T = TypeVar("T")
State = Literal["ok", "warning", "wrong"]

_SIGNS: dict[State, str] = {"ok": "[green]✓[/green]", "warning": "[yellow]![/yellow]", "wrong": "[red]✗[/red]"}


@dataclass(frozen=True)
class Finding:
    """One line of the checklist.

    Attributes:
        check: what was looked at.
        state: how it is.
        seen: what was seen.
        advice: what to do; "" where there is nothing to do.
    """

    check: str
    state: State
    seen: str
    advice: str = ""


class TookTooLong(Exception):
    """A step did not come to an end in time."""


class Budget:
    """The time that is left for everything."""

    def __init__(self, seconds: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._until = clock() + seconds

    def step(self, seconds: float) -> float:
        """So long, but no longer than what is left."""
        return max(0.05, min(seconds, self._until - self._clock()))

    def within(self, seconds: float, work: Callable[[], T]) -> T:
        """The result of `work`, which may hang: it is then left behind.

        Raises:
            TookTooLong: it did.
            Exception: what it raises.
        """
        done: list[T] = []
        failed: list[Exception] = []

        def run() -> None:
            try:
                done.append(work())
            except Exception as error:  # whatever it is, it belongs to the caller
                failed.append(error)

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        thread.join(self.step(seconds))
        if failed:
            raise failed[0]
        if not done:
            raise TookTooLong
        return done[0]


def checklist(findings: list[Finding]) -> Table:
    """The findings as a table."""
    headings = (Column(heading, overflow="fold") for heading in ("", "check", "seen", "what to do"))
    table = Table(*headings, title="voa doctor", title_justify="left")
    for finding in findings:
        table.add_row(_SIGNS[finding.state], escape(finding.check), escape(finding.seen), escape(finding.advice))
    return table
