"""Tables that several commands print."""

from rich.console import Console
from rich.table import Column, Table

from voa_client.formatting import bar, ranks, scale, share, signed, unsigned
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import GivenScores, Scenario

_BAR = 24
"""Characters of a full bar where a line has room for it."""
_EDGE = 3  # characters between a column and the next


def ranking_table(console: Console, ranking: Ranking) -> Table:
    """Show the looks of a ranking, best first; what they cost and are worth net of it, if one costs anything.

    Their VOA is drawn as a bar, as long as the console's line has room for beside the figures.
    """
    most = max((look.voa for look in ranking.ranking), default=0.0)
    plain = _table(ranking, most, 0)
    room = console.width - console.measure(plain).maximum - _EDGE
    return plain if room < len(scale(most)) or most <= 0.0 else _table(ranking, most, min(_BAR, room))


def _table(ranking: Ranking, most: float, width: int) -> Table:
    """The table with bars of so many characters for a VOA of `most`; without them for 0."""
    costs = any(look.cost for look in ranking.ranking)
    table = Table(Column("rank", justify="right"), "sensor", Column("VOA", justify="right", no_wrap=True))
    if width:
        table.add_column(scale(most), no_wrap=True, min_width=width)
    for heading in (*(("cost", "net value") if costs else ()), "score after"):
        table.add_column(heading, justify="right", no_wrap=True)
    for rank, look in zip(ranks(ranking), ranking.ranking, strict=True):
        drawn = (bar(look.voa, most, width),) if width else ()
        money = (unsigned(look.cost), signed(look.net_value)) if costs else ()
        table.add_row(rank, look.sensor, signed(look.voa), *drawn, *money, share(look.expected_score_after, 3))
    return table


def scores_of(scenario: Scenario) -> list[list[float]]:
    """Grasp scores, grasps x poses."""
    if isinstance(scenario.scores, GivenScores):
        return scenario.scores.probabilities
    return [[count / scenario.scores.attempts for count in row] for row in scenario.scores.successes]


def weighted_scores(scenario: Scenario, belief: list[float]) -> list[list[float]]:
    """b[p] Q[x, p], poses x grasps (equation 4 of the paper)."""
    scores = scores_of(scenario)
    return [[share * row[pose] for row in scores] for pose, share in enumerate(belief)]
