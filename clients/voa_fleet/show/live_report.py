"""How a episode is told in a terminal: lines as it happens, and on a terminal a live table beside them."""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from rich.console import Console, RenderableType
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from voa_client.readable import bar, no_look, ranks, scale, share, signed, signed_apart
from voa_fleet.episodes.looks import TakenLook
from voa_fleet.episodes.episode import RobotArrived, LookChosen, Event, GraspEnded, GraspStarted, Step, LookTaken, SessionOpened, OutcomeReported
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session

_BAR = 12
_FEW = 3
_LINES = 16
"""Of the table of one pair, where nothing says how high the screen is."""
_FRAME = 6
"""Lines of a screen that the table's title and frame take, and the cursor below it."""


def event_line(what: Step) -> str:
    """What has happened, in a line."""
    match what:
        case SessionOpened(session=session):
            line = f"session {session.id}: {_belief(session)}; {_best(session)}"
        case LookChosen():
            line = _choice(what)
        case RobotArrived(sensor=sensor, pose=pose):
            line = f"the robot stands at {sensor}, x {pose.x:.3f} m, y {pose.y:.3f} m"
        case LookTaken(look=look):
            line = f"looked from {look.sensor}: {_update(look)}{_belief(look.after)}; {_best(look.after)}"
        case GraspStarted(grasp=None):
            line = "no grasp within reach is expected to succeed: the arm stays where it is"
        case GraspStarted(grasp=grasp, expected_score=score):
            line = f"the arm tries {grasp}, expected to succeed with {share(score)}"
        case GraspEnded(outcome=outcome):
            how = f": {outcome.detail}" if outcome.detail else ""
            line = f"{outcome.grasp} {'succeeded' if outcome.success else 'FAILED'}{how}"
        case OutcomeReported(after=None):
            line = "not reported: the attempt has moved the object, and the belief is about where it was"
        case OutcomeReported(after=after):
            told = "took it as evidence" if after is not None and after.update.accepted else "made nothing of it"
            line = f"outcome reported: the service {told}"
    return line


def _choice(chosen: LookChosen) -> str:
    ranking = chosen.ranking
    if ranking is None or not ranking.ranking:
        if chosen.sensor is not None:
            return f"look from {chosen.sensor} next"
        return "the looks are used up: grasp" if chosen.used_up else "no more looks: grasp"
    if chosen.sensor is None and not chosen.used_up:
        return f"{no_look(ranking, chosen.min_gain)}: grasp"
    first, *others = ranking.ranking[:_FEW]
    worth = f"{first.sensor} is worth {signed_apart(first.net_value, chosen.min_gain)}"
    if chosen.sensor is None:
        return f"the looks are used up ({worth}): grasp"
    rest = "".join(f", {o.sensor} {'as much' if o.ties_with_first else signed(o.net_value)}" for o in others)
    return f"look from {chosen.sensor} next ({worth}{rest})"


def _update(look: TakenLook) -> str:
    if look.update is None:
        return "not accepted; "
    if not look.update.accepted:
        return f"not accepted ({look.update.reason}); "
    fit = look.update.fit_hit_rmsd_mm
    return "" if fit is None else f"best fit {fit:.1f} mm; "


def _belief(session: Session) -> str:
    likely = sorted(zip(session.belief, session.poses, strict=True), key=lambda pair: -pair[0])
    if likely[0][0] - likely[-1][0] < 1e-9:
        return f"{len(likely)} poses, all {share(likely[0][0])}"
    return ", ".join(f"{pose} {share(held)}" for held, pose in likely[:_FEW])


def _best(session: Session) -> str:
    return f"best grasp {session.best_grasp or 'none'}, {share(session.expected_score)}"


@dataclass(frozen=True)
class Row:
    """One pair, as it stands.

    Attributes:
        ranking: the newest; None: none was asked for.
        looks: from where, so far.
        doing: the newest line.
        success: whether the grasp succeeded; None: it was not tried yet.
    """

    pair: str
    session: Session | None = None
    ranking: Ranking | None = None
    looks: tuple[str, ...] = ()
    doing: str = ""
    at_s: float = 0.0
    success: bool | None = None

    def after(self, event: Event) -> "Row":
        """The row when something has happened."""
        row = replace(self, doing=event_line(event.what), at_s=event.at_s)
        match event.what:
            case SessionOpened(session=session):
                return replace(row, session=session)
            case LookChosen(ranking=ranking):
                return replace(row, ranking=ranking)
            case LookTaken(look=look):
                return replace(row, session=look.after, looks=(*self.looks, look.sensor))
            case GraspEnded(outcome=outcome):
                return replace(row, success=outcome.success)
            case _:
                return row


def belief_table(row: Row, most_lines: int = _LINES) -> Table:
    """Show what one pair believes, and what looks are worth to it, in few enough lines for a screen.

    Args:
        row: the pair.
        most_lines: below the heading, at least 2. Of more poses the likeliest come first, of more looks those that
            are worth most, and a last line sums up the others.
    """
    looks = () if row.ranking is None else row.ranking.ranking
    most = max((look.voa for look in looks), default=0.0)
    table = Table(title=f"{row.pair}, {row.at_s:.0f} s", title_justify="left", expand=False)
    for heading in ("pose", "belief", scale(1.0), "rank", "look from", "VOA", scale(most)):
        table.add_column(heading, justify="right" if heading in ("belief", "rank", "VOA") else "left", no_wrap=True)
    table.columns[2].min_width = _BAR
    left, right = _pose_cells(row.session, most_lines), _look_cells(row.ranking, most, most_lines)
    for index in range(max(len(left), len(right))):
        table.add_row(
            *(left[index] if index < len(left) else ("",) * 3), *(right[index] if index < len(right) else ("",) * 4)
        )
    return table


def _pose_cells(session: Session | None, most_lines: int) -> Sequence[tuple[str, ...]]:
    """Name, share and bar of every pose as listed; of the likeliest where there are more than `most_lines`."""
    if session is None:
        return []
    held = list(zip(session.poses, session.belief, strict=True))
    shown = held if len(held) <= most_lines else sorted(held, key=lambda pair: -pair[1])[: most_lines - 1]
    cells = [(escape(pose), share(value), f"[blue]{bar(value, 1.0, _BAR)}[/blue]") for pose, value in shown]
    if len(shown) < len(held):
        rest = max(0.0, 1.0 - math.fsum(value for _, value in shown))
        cells.append((f"{len(held) - len(shown)} others", share(rest), f"[dim]{bar(rest, 1.0, _BAR)}[/dim]"))
    return cells


def _look_cells(ranking: Ranking | None, most: float, most_lines: int) -> Sequence[tuple[str, ...]]:
    """Rank, name, VOA and bar of every look, best first."""
    if ranking is None:
        return []
    looks = list(zip(ranks(ranking), ranking.ranking, strict=True))
    shown = looks if len(looks) <= most_lines else looks[: most_lines - 1]
    cells = [
        (rank, escape(look.sensor), signed(look.voa), f"[yellow]{bar(look.voa, most, _BAR)}[/yellow]")
        for rank, look in shown
    ]
    if len(shown) < len(looks):
        cells.append(("", f"{len(looks) - len(shown)} others", "", ""))
    return cells


def fleet_table(rows: list[Row]) -> Table:
    """All pairs, a line each."""
    table = Table()
    for heading in ("pair", "time", "looks from", "believes", "best grasp", "outcome"):
        table.add_column(heading)
    for row in rows:
        session = row.session
        table.add_row(
            row.pair,
            f"{row.at_s:.0f} s",
            escape(" ".join(row.looks) or "-"),
            "" if session is None else escape(_belief(session)),
            "" if session is None else escape(f"{session.best_grasp or 'none'} {share(session.expected_score)}"),
            "" if row.success is None else "lifted" if row.success else "[bold]failed[/bold]",
        )
    return table


def _unpaced(_what: Step) -> None:
    """Without pauses."""


@dataclass(eq=False)
class LiveReport:
    """Tells what happens to any number of pairs, from any thread; use as a context manager.

    In a pipe: a line for every event. On a terminal the same, and below it a table that follows: belief and ranking
    of one pair, or a row for each of several.

    Attributes:
        console: where it is printed.
        pairs: their names.
        lines: whether events are printed; the table alone stays quiet about them.
        pace: called after every event, outside of the lock: to give a reader time.
    """

    console: Console
    pairs: tuple[str, ...]
    lines: bool = True
    pace: Callable[[Step], None] = _unpaced
    _rows: dict[str, Row] = field(init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _live: Live | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._rows = {name: Row(name) for name in self.pairs}

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
    def rows(self) -> list[Row]:
        """Every pair, as it stands."""
        with self._lock:
            return list(self._rows.values())

    def __call__(self, event: Event) -> None:
        """Tell an event."""
        with self._lock:
            self._rows[event.pair] = self._rows[event.pair].after(event)
            if self.lines:
                self._print(event)
            if self._live is not None:
                self._live.update(self._table(), refresh=True)
        self.pace(event.what)

    def _print(self, event: Event) -> None:
        """Print a line: whole in a pipe, on a terminal broken between words and indented."""
        time = f"[dim]{event.at_s:6.1f} s[/dim]"
        whose = f"[dim]{event.pair}[/dim] " if len(self.pairs) > 1 else ""
        line = f"{whose}{_marked(event.what)}"
        if not self.console.is_terminal:
            self.console.print(f"{time}  {line}", highlight=False, soft_wrap=True)
            return
        grid = Table.grid(padding=(0, 2))
        grid.add_column(no_wrap=True)
        grid.add_row(time, line)
        self.console.print(grid)

    def _table(self) -> RenderableType:
        rows = list(self._rows.values())
        if len(rows) > 1:
            return fleet_table(rows)
        return belief_table(rows[0], max(2, self.console.height - _FRAME))


def _marked(what: Step) -> str:
    """The line, with what matters standing out."""
    line = escape(event_line(what))
    match what:
        case GraspEnded(outcome=outcome):
            return f"[bold {'green' if outcome.success else 'red'}]{line}[/]"
        case LookChosen() | GraspStarted():
            return f"[bold]{line}[/bold]"
        case _:
            return line
