"""Findings of checks, and time limits for checks."""

import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

from rich.markup import escape
from rich.padding import Padding
from rich.table import Table

T = TypeVar("T")
State = Literal["ok", "warning", "wrong"]

_SIGNS: dict[State, str] = {"ok": "[green]✓[/green]", "warning": "[yellow]![/yellow]", "wrong": "[red]✗[/red]"}


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


def checklist(findings: Sequence[Finding]) -> Table:
    """Lay findings out as a list that can be read at any width: the observation, and below it the advice."""
    table = Table.grid(padding=(0, 1))
    table.add_column()
    table.add_column(overflow="fold")
    for finding in findings:
        lines = Table.grid(padding=(0, 1))
        lines.add_column(overflow="fold")
        lines.add_row(f"[bold]{escape(finding.check)}:[/bold] {escape(finding.seen)}")
        if finding.advice:
            lines.add_row(Padding(escape(f"-> {finding.advice}"), (0, 0, 0, 2)))
        table.add_row(_SIGNS[finding.state], lines)
    return table


def verdict(findings: Sequence[Finding]) -> str:
    """Count the wrong findings and the warnings in a line."""
    states = Counter(finding.state for finding in findings)
    warnings = f"{states['warning']} warning{'' if states['warning'] == 1 else 's'}"
    return f"{states['wrong'] or 'nothing'} wrong, {warnings if states['warning'] else 'no warnings'}"
