"""How a story is told in a terminal: lines as it happens, and on a terminal a live table beside them."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table

from voa_fleet.story import Arrived, Chosen, Event, Grasped, Grasping, Happening, Looked, Opened, Reported, TakenLook
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session

_BAR = 16
_FEW = 3


def line_of(what: Happening) -> str:
    """What has happened, in a line."""
    match what:
        case Opened(session=session):
            line = f"session {session.id}: {_belief(session)}; {_best(session)}"
        case Chosen():
            line = _choice(what)
        case Arrived(sensor=sensor, pose=pose):
            line = f"the robot stands at {sensor}, x {pose.x:.3f} m, y {pose.y:.3f} m"
        case Looked(look=look):
            line = f"looked from {look.sensor}: {_update(look)}{_belief(look.after)}; {_best(look.after)}"
        case Grasping(grasp=None):
            line = "no grasp within reach is expected to succeed: the arm stays where it is"
        case Grasping(grasp=grasp, expected_score=score):
            line = f"the arm tries {grasp}, expected to succeed with {score:.2f}"
        case Grasped(outcome=outcome):
            how = f": {outcome.detail}" if outcome.detail else ""
            line = f"{outcome.grasp} {'succeeded' if outcome.success else 'FAILED'}{how}"
        case Reported(after=None):
            line = "not reported: the attempt has moved the object, and the belief is about where it was"
        case Reported(after=after):
            told = "took it as evidence" if after is not None and after.update.accepted else "made nothing of it"
            line = f"outcome reported: the service {told}"
    return line


def _choice(chosen: Chosen) -> str:
    worth = ""
    if chosen.ranking is not None and chosen.ranking.ranking:
        first = chosen.ranking.ranking[0]
        worth = f" ({first.sensor} is worth {first.voa:+.3f})"
    if chosen.sensor is not None:
        others = [] if chosen.ranking is None else chosen.ranking.ranking[1:_FEW]
        rest = "".join(f", {look.sensor} {look.voa:+.3f}" for look in others)
        return f"look from {chosen.sensor} next{worth[:-1] + rest + ')' if worth else ''}"
    return f"the looks are used up{worth}: grasp" if chosen.used_up else f"no more looks{worth}: grasp"


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
        return f"{len(likely)} poses, all {likely[0][0]:.2f}"
    return ", ".join(f"{pose} {share:.2f}" for share, pose in likely[:_FEW])


def _best(session: Session) -> str:
    return f"best grasp {session.best_grasp or 'none'}, {session.expected_score:.2f}"


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
        row = replace(self, doing=line_of(event.what), at_s=event.at_s)
        match event.what:
            case Opened(session=session):
                return replace(row, session=session)
            case Chosen(ranking=ranking):
                return replace(row, ranking=ranking)
            case Looked(look=look):
                return replace(row, session=look.after, looks=(*self.looks, look.sensor))
            case Grasped(outcome=outcome):
                return replace(row, success=outcome.success)
            case _:
                return row


def belief_table(row: Row) -> Table:
    """What one pair believes, and what looks are worth to it."""
    table = Table(title=f"{row.pair}, {row.at_s:.0f} s", title_justify="left", expand=False)
    for heading in ("pose", "belief", "", "look from", "worth", " "):
        table.add_column(heading, justify="right" if heading in ("belief", "worth") else "left")
    beliefs = [] if row.session is None else list(zip(row.session.poses, row.session.belief, strict=True))
    looks = [] if row.ranking is None else [(look.sensor, look.voa) for look in row.ranking.ranking]
    most = max((abs(voa) for _, voa in looks), default=0.0) or 1.0
    for index in range(max(len(beliefs), len(looks))):
        left = ("", "", "")
        right = ("", "", "")
        if index < len(beliefs):
            pose, share = beliefs[index]
            left = (pose, f"{share:.2f}", f"[blue]{'█' * round(_BAR * share)}[/blue]")
        if index < len(looks):
            sensor, voa = looks[index]
            right = (sensor, f"{voa:+.3f}", f"[yellow]{'█' * round(_BAR * max(voa, 0.0) / most)}[/yellow]")
        table.add_row(*left, *right)
    return table


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
            " ".join(row.looks) or "-",
            "" if session is None else _belief(session),
            "" if session is None else f"{session.best_grasp or 'none'} {session.expected_score:.2f}",
            "" if row.success is None else "lifted" if row.success else "[bold]failed[/bold]",
        )
    return table


def _unpaced(_what: Happening) -> None:
    """Without pauses."""


@dataclass(eq=False)
class Teller:
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
    pace: Callable[[Happening], None] = _unpaced
    _rows: dict[str, Row] = field(init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _live: Live | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._rows = {name: Row(name) for name in self.pairs}

    def __enter__(self) -> "Teller":
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
                whose = f"[dim]{event.pair}[/dim] " if len(self.pairs) > 1 else ""
                self.console.print(
                    f"[dim]{event.at_s:6.1f} s[/dim]  {whose}{_marked(event.what)}", highlight=False, soft_wrap=True
                )
            if self._live is not None:
                self._live.update(self._table(), refresh=True)
        self.pace(event.what)

    def _table(self) -> RenderableType:
        rows = list(self._rows.values())
        return belief_table(rows[0]) if len(rows) == 1 else Group(fleet_table(rows))


def _marked(what: Happening) -> str:
    """The line, with what matters standing out."""
    line = line_of(what)
    match what:
        case Grasped(outcome=outcome):
            return f"[bold {'green' if outcome.success else 'red'}]{line}[/]"
        case Chosen() | Grasping():
            return f"[bold]{line}[/bold]"
        case _:
            return line
