"""Expected scores of grasps under a belief, for past versions, of which the service ranks no grasps."""

from collections.abc import Sequence

from voa_msgs.scenarios import GivenScores, Scenario


def expected_scores(scenario: Scenario, belief: Sequence[float]) -> list[tuple[str, float]]:
    """Return each grasp with its expected score under `belief`, 0 to 1, the best first, equals as listed.

    The score of a measured grasp is its successes divided by its attempts.
    """
    scores = scenario.scores
    if isinstance(scores, GivenScores):
        rows: Sequence[Sequence[float]] = scores.probabilities
    else:
        rows = [[count / scores.attempts for count in row] for row in scores.successes]
    scored = [
        (grasp.name, sum(share * score for share, score in zip(belief, row, strict=True)))
        for grasp, row in zip(scenario.grasps, rows, strict=True)
    ]
    return sorted(scored, key=lambda pair: -round(pair[1], 12))
