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


def checklist(findings: Sequence[Finding]) -> Table:
    """Lay the findings out as a list that can be read at any width: what was seen, and below it what to do."""
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
    """Say in one line how many things are wrong, and how many are worth a look."""
    states = Counter(finding.state for finding in findings)
    warnings = f"{states['warning']} warning{'' if states['warning'] == 1 else 's'}"
    return f"{states['wrong'] or 'nothing'} wrong, {warnings if states['warning'] else 'no warnings'}"
