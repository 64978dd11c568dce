"""Tables of rankings and grasp scores that several commands print."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from rich.console import Console
from rich.table import Table

from voa_client.formatting import bar, ranks, scale, share, signed, unsigned, with_error
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import GivenScores, Scenario

_BAR = 24
"""Characters of a full bar where a line has room for it."""
_EDGE = 3  # characters between a column and the next
_UNLIMITED = 10_000
_LEAST_NEEDED = ("score after", "looks taken")
"""Columns in the order in which they are left out where a line has no room for them."""


@dataclass(frozen=True)
class _Figures:
    """A column of the table: its heading, and a cell for each look."""

    heading: str
    cells: tuple[str, ...]
    justify: Literal["left", "right"] = "right"
    wraps: bool = False


def ranking_table(console: Console, ranking: Ranking) -> Table:
    """Make a table of the looks of a ranking, best first: VOA with its standard error, costs and looks taken if any.

    VOA is drawn as a bar as well, if the console is wide enough; if it is too narrow, columns are left out.
    """
    columns = _columns(ranking)
    most = max((look.voa for look in ranking.ranking), default=0.0)
    for heading in _LEAST_NEEDED:
        if _width(console, columns) > console.width:
            columns = [column for column in columns if column.heading != heading]
    room = console.width - _width(console, columns) - _EDGE
    if room < len(scale(most)) or most <= 0.0:
        return _table(columns)
    bars = _Figures(scale(most), tuple(bar(look.voa, most, min(_BAR, room)) for look in ranking.ranking), "left")
    return _table([*columns[:3], bars, *columns[3:]], min(_BAR, room))


def _width(console: Console, columns: Sequence[_Figures]) -> int:
    """Number of characters that a line of the table needs, however wide the console is."""
    unlimited = console.options.update(max_width=_UNLIMITED)
    return console.measure(_table(columns), options=unlimited).maximum


def _columns(ranking: Ranking) -> list[_Figures]:
    """Columns of the table without bars: rank, sensor and VOA first."""
    looks = ranking.ranking
    columns = [
        _Figures("rank", tuple(ranks(ranking)), wraps=True),
        _Figures("sensor", tuple(look.sensor for look in looks), "left", wraps=True),
        _Figures("VOA", tuple(with_error(look.voa, look.standard_error) for look in looks)),
    ]
    if any(look.cost for look in looks):
        columns.append(_Figures("cost", tuple(unsigned(look.cost) for look in looks)))
        columns.append(_Figures("net value", tuple(signed(look.net_value) for look in looks)))
    columns.append(_Figures("score after", tuple(share(look.expected_score_after, 3) for look in looks)))
    if any(look.looks_taken for look in looks):
        columns.append(_Figures("looks taken", tuple(str(look.looks_taken) for look in looks)))
    return columns


def _table(columns: Sequence[_Figures], bar_width: int = 0) -> Table:
    """Make the table; its column of bars, if there is one, is at least `bar_width` characters wide."""
    table = Table()
    for column in columns:
        width = bar_width if column.heading.startswith("0 to ") else None
        table.add_column(column.heading, justify=column.justify, no_wrap=not column.wraps, min_width=width)
    for row in zip(*(column.cells for column in columns), strict=True):
        table.add_row(*row)
    return table


def scores_of(scenario: Scenario) -> list[list[float]]:
    """Return the grasp scores of a scenario, grasps x poses, as probabilities."""
    if isinstance(scenario.scores, GivenScores):
        return scenario.scores.probabilities
    return [[count / scenario.scores.attempts for count in row] for row in scenario.scores.successes]


def weighted_scores(scenario: Scenario, belief: list[float]) -> list[list[float]]:
    """Return b[p] Q[x, p], poses x grasps (equation 4 of the paper), for a belief with a probability per pose."""
    scores = scores_of(scenario)
    return [[share * row[pose] for row in scores] for pose, share in enumerate(belief)]
