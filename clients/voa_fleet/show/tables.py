"""Tables of pairs in a terminal: belief and looks of one, or a line for each of several."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from rich.markup import escape
from rich.table import Table

from voa_client.formatting import bar, ranks, scale, share, signed
from voa_fleet.episodes.events import Event, GraspEnded, LookChosen, LookTaken, SessionOpened
from voa_fleet.show.event_lines import belief_summary
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session

_BAR = 12
_LINES = 16
"""Lines of the table of one pair where the height of the screen is not known."""


@dataclass(frozen=True)
class PairState:
    """Latest state of a pair, as its events show it.

    Attributes:
        pair: name of the pair.
        session: its latest state; None: it is not open yet.
        ranking: the latest one; None: the policy requested none.
        looks: names of the sensor configurations from which looks were taken.
        at_s: time of the latest event, seconds.
        success: True if the grasp succeeded; None: it was not attempted yet.
    """

    pair: str
    session: Session | None = None
    ranking: Ranking | None = None
    looks: tuple[str, ...] = ()
    at_s: float = 0.0
    success: bool | None = None

    def after(self, event: Event) -> "PairState":
        """Return the state after an event."""
        state = replace(self, at_s=event.at_s)
        match event.step:
            case SessionOpened(session=session):
                return replace(state, session=session)
            case LookChosen(ranking=ranking):
                return replace(state, ranking=ranking)
            case LookTaken(look=look):
                return replace(state, session=look.after, looks=(*self.looks, look.sensor))
            case GraspEnded(outcome=outcome):
                return replace(state, success=outcome.success)
            case _:
                return state


def belief_table(state: PairState, most_lines: int = _LINES) -> Table:
    """Make a table of a pair's belief and of the VOA of its looks.

    Args:
        state: of the pair.
        most_lines: number of lines below the heading, at least 2. Where there are more poses, the likeliest come
            first, where there are more looks, the most valuable; the last line sums up the others.
    """
    looks = () if state.ranking is None else state.ranking.ranking
    most = max((look.voa for look in looks), default=0.0)
    absent = None if state.session is None else state.session.absent
    note = "" if absent is None else f", absent {share(absent)}"
    table = Table(title=f"{state.pair}, {state.at_s:.0f} s{note}", title_justify="left", expand=False)
    for heading in ("pose", "belief", scale(1.0), "rank", "look from", "VOA", scale(most)):
        table.add_column(heading, justify="right" if heading in ("belief", "rank", "VOA") else "left", no_wrap=True)
    table.columns[2].min_width = _BAR
    left, right = _pose_cells(state.session, most_lines), _look_cells(state.ranking, most, most_lines)
    for index in range(max(len(left), len(right))):
        table.add_row(
            *(left[index] if index < len(left) else ("",) * 3), *(right[index] if index < len(right) else ("",) * 4)
        )
    return table


def _pose_cells(session: Session | None, most_lines: int) -> Sequence[tuple[str, ...]]:
    """Name, share and bar of every pose in order; of the likeliest where there are more than `most_lines`."""
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


def fleet_table(states: list[PairState]) -> Table:
    """Make a table of several pairs, with a line for each."""
    table = Table()
    for heading in ("pair", "time", "looks from", "believes", "best grasp", "outcome"):
        table.add_column(heading)
    for state in states:
        session = state.session
        table.add_row(
            state.pair,
            f"{state.at_s:.0f} s",
            escape(" ".join(state.looks) or "-"),
            "" if session is None else escape(belief_summary(session)),
            "" if session is None else escape(f"{session.best_grasp or 'none'} {share(session.expected_score)}"),
            "" if state.success is None else "lifted" if state.success else "[bold]failed[/bold]",
        )
    return table
