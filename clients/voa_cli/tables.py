"""Tables that several commands print."""

from rich.table import Column, Table

from voa_client.readable import bar, ranks, scale, share, signed, unsigned
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import GivenScores, Scenario

_BAR, _SHORT_BAR = 24, 12
"""Characters of a full bar: without costs, and with them, so that a line has at most 80."""


def ranking_table(ranking: Ranking, costs: bool) -> Table:
    """Show the looks of a ranking, best first, with their VOA as a bar; with `costs` their net value too."""
    most = max((look.voa for look in ranking.ranking), default=0.0)
    width = _SHORT_BAR if costs else _BAR
    table = Table(
        Column("rank", justify="right"),
        "sensor",
        Column("VOA", justify="right"),
        Column(scale(most), no_wrap=True, min_width=width),
    )
    for heading in (*(("cost", "net value") if costs else ()), "score after"):
        table.add_column(heading, justify="right")
    for rank, look in zip(ranks(ranking), ranking.ranking, strict=True):
        money = (unsigned(look.cost), signed(look.net_value)) if costs else ()
        after = share(look.expected_score_after, 3)
        table.add_row(rank, look.sensor, signed(look.voa), bar(look.voa, most, width), *money, after)
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
