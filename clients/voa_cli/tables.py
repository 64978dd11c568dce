"""Tables that several commands print."""

from rich.table import Table

from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import GivenScores, Scenario

_BAR = 24


def ranking_table(ranking: Ranking, costs: bool) -> Table:
    """Looks, best first: VOA as a bar, and with `costs` what is left after them."""
    table = Table(title=f"Where to look: Value of Assistance ({ranking.definition})", title_justify="left")
    table.add_column("sensor")
    table.add_column("VOA", justify="right")
    if costs:
        table.add_column("cost", justify="right")
        table.add_column("net value", justify="right")
    table.add_column("expected score after", justify="right")
    table.add_column("")
    most = max((abs(look.voa) for look in ranking.ranking), default=0.0) or 1.0
    for look in ranking.ranking:
        money = (f"{look.cost:.3f}", f"{look.net_value:+.3f}") if costs else ()
        bar = "█" * round(_BAR * max(look.voa, 0.0) / most)
        table.add_row(look.sensor, f"{look.voa:+.3f}", *money, f"{look.expected_score_after:.3f}", bar)
    return table


def recommendation(ranking: Ranking) -> str:
    """What to do now, in a sentence."""
    advice = ranking.recommendation
    if advice.action == "look":
        return f"look from [bold]{advice.sensor}[/bold] first (net value {advice.net_value:+.3f})"
    if advice.grasp is None:
        return "no look is worth its cost, and no grasp can succeed"
    return f"grasp now with [bold]{advice.grasp}[/bold] (expected score {advice.expected_score:.3f})"


def scores_of(scenario: Scenario) -> list[list[float]]:
    """Grasp scores, grasps x poses."""
    if isinstance(scenario.scores, GivenScores):
        return scenario.scores.probabilities
    return [[count / scenario.scores.attempts for count in row] for row in scenario.scores.successes]


def weighted_scores(scenario: Scenario, belief: list[float]) -> list[list[float]]:
    """b[p] Q[x, p], poses x grasps (equation 4 of the paper)."""
    scores = scores_of(scenario)
    return [[share * row[pose] for row in scores] for pose, share in enumerate(belief)]
