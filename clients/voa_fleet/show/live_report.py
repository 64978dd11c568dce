"""Live report of episodes in a terminal: a line for each event, and a table that is kept up to date."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from rich.console import Console, RenderableType
from rich.live import Live
from rich.table import Table

from voa_fleet.episodes.events import Event, Step
from voa_fleet.show.event_lines import marked_line
from voa_fleet.show.tables import PairState, belief_table, fleet_table

_FRAME = 6
"""Lines of a screen that the table's title and frame take, and the cursor below it."""


def _unpaced(_step: Step) -> None:
    """Make no pause."""


@dataclass(eq=False)
class LiveReport:
    """Report of the events of any number of pairs, from any thread; use it as a context manager, and as a listener.

    In a pipe it prints a line for every event. On a terminal it keeps a table up to date below the lines: belief and
    ranking of one pair, or a row for each of several.

    Attributes:
        console: on which it prints.
        pairs: names of the pairs.
        lines: True if it prints a line for every event, beside the table.
        pace: called after every event, outside of the lock, to give a reader time.
    """

    console: Console
    pairs: tuple[str, ...]
    lines: bool = True
    pace: Callable[[Step], None] = _unpaced
    _states: dict[str, PairState] = field(init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _live: Live | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._states = {name: PairState(name) for name in self.pairs}

    def __enter__(self) -> "LiveReport":
        if self.console.is_terminal:
            self._live = Live(self._table(), console=self.console, auto_refresh=False)
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None

    @property
    def states(self) -> list[PairState]:
        """Latest state of every pair, in order."""
        with self._lock:
            return list(self._states.values())

    def __call__(self, event: Event) -> None:
        """Report an event."""
        with self._lock:
            self._states[event.pair] = self._states[event.pair].after(event)
            if self.lines:
                self._print(event)
            if self._live is not None:
                self._live.update(self._table(), refresh=True)
        self.pace(event.step)

    def _print(self, event: Event) -> None:
        """Print a line: whole in a pipe, on a terminal broken between words and indented."""
        time = f"[dim]{event.at_s:6.1f} s[/dim]"
        whose = f"[dim]{event.pair}[/dim] " if len(self.pairs) > 1 else ""
        line = f"{whose}{marked_line(event.step)}"
        if not self.console.is_terminal:
            self.console.print(f"{time}  {line}", highlight=False, soft_wrap=True)
            return
        grid = Table.grid(padding=(0, 2))
        grid.add_column(no_wrap=True)
        grid.add_row(time, line)
        self.console.print(grid)

    def _table(self) -> RenderableType:
        states = list(self._states.values())
        if len(states) > 1:
            return fleet_table(states)
        return belief_table(states[0], max(2, self.console.height - _FRAME))
