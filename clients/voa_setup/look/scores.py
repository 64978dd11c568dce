"""Grasp scores as figures and as words."""

from collections.abc import Sequence

from voa_client.formatting import share
from voa_msgs.scenarios import MeasuredScores, ScenarioRequest


def best_of(scores: Sequence[float]) -> int:
    """Return the index of the largest score, the first of equals."""
    return scores.index(max(scores))


def score(scenario: ScenarioRequest, grasp: int, pose: int) -> float:
    """Share of successes, or the probability, of a grasp at a pose."""
    scores = scenario.scores
    if isinstance(scores, MeasuredScores):
        return scores.successes[grasp][pose] / scores.attempts
    return scores.probabilities[grasp][pose]


def score_text(scenario: ScenarioRequest, grasp: int, pose: int) -> str:
    """Write a score as k of n, or as a probability."""
    scores = scenario.scores
    if isinstance(scores, MeasuredScores):
        return f"{scores.successes[grasp][pose]} of {scores.attempts}"
    return share(scores.probabilities[grasp][pose])


def score_in_words(scenario: ScenarioRequest, grasp: int, pose: int) -> str:
    """Write how often a grasp succeeds at its best pose, to follow its name."""
    if score(scenario, grasp, pose) <= 0.0:
        return "succeeds at no pose"
    if isinstance(scenario.scores, MeasuredScores):
        return f"succeeds in {score_text(scenario, grasp, pose)} attempts"
    return f"succeeds with probability {score_text(scenario, grasp, pose)}"
