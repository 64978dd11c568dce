"""Choice of grasps that cover the poses, and then differ from each other."""

from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import Floats

IMPROVEMENT = 0.2
"""Improvement of the best score at some pose for which a grasp is chosen to cover poses."""
USEFUL = 0.4
"""Smallest score at some pose with which a grasp is worth listing."""


@dataclass(frozen=True, eq=False)
class Ranked:
    """Candidates with what the choice needs.

    Attributes:
        scores: (c, n), of each candidate at each pose.
        merits: (c,), small preferences between equal scores.
        features: (c, f), coordinates in which different kinds of grasp lie apart, about 1 for clearly different ones.
    """

    scores: Floats
    merits: Floats
    features: Floats


def choose(candidates: Ranked, prior: Floats, count: int) -> list[int]:
    """Choose candidates: greedily those that add most to the expected best score, then those most unlike the others.

    The expected best score is `sum_p prior[p] * max_x Q[x, p]` over the chosen grasps x.

    Args:
        candidates: to choose from.
        prior: (n,), probability of each pose.
        count: most candidates to choose.

    Returns:
        Indices of candidates in the order of choice.
    """
    chosen: list[int] = []
    best = np.zeros(len(prior))
    top = candidates.scores.max(axis=1, initial=0.0)
    useful, apart = top >= USEFUL, np.ones(len(top))
    while len(chosen) < count and useful.any():
        gain = np.maximum(candidates.scores - best, 0.0)
        covering = useful & ((gain >= IMPROVEMENT) & (prior > 0.0)).any(axis=1)
        if covering.any():
            value = np.where(covering, (gain @ prior) * (1.0 + candidates.merits), -np.inf)
        else:
            value = np.where(useful, (top + candidates.merits) ** 2 * np.minimum(apart, 1.0), -np.inf)
        index = int(value.argmax())
        chosen.append(index)
        useful[index] = False
        best = np.maximum(best, candidates.scores[index])
        apart = np.minimum(apart, _distance(candidates.features, index))
    return chosen


def thin(quality: Floats, features: Floats, count: int) -> list[int]:
    """Thin candidates out to `count`: the best first, then good ones that are most unlike those taken.

    Args:
        quality: (c,), positive.
        features: (c, f), coordinates in which candidates differ.
        count: most candidates to take.

    Returns:
        Indices of candidates.
    """
    taken: list[int] = []
    apart = np.ones(len(quality))
    while len(taken) < min(count, len(quality)):
        value = quality * apart
        value[taken] = -np.inf
        index = int(value.argmax())
        taken.append(index)
        apart = np.minimum(apart, _distance(features, index))
    return taken


def _distance(features: Floats, index: int) -> Floats:
    distance: Floats = np.linalg.norm(features - features[index], axis=1)
    return distance
