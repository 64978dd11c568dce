"""The table of grasp scores Q[x, p], and the choice of a grasp under a belief."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from voa_core.checks import Floats, finite_array, frozen, indices, unique_names
from voa_core.errors import InvalidInput

TIE = 1e-12


@dataclass(frozen=True, eq=False)
class GraspTable:
    """Probability of success of each grasp at each pose (Definition 1).

    Attributes:
        names: one per grasp, all different.
        scores: (m, n), in [0, 1].
    """

    names: tuple[str, ...]
    scores: Floats

    @classmethod
    def of_probabilities(cls, names: Sequence[str], probabilities: ArrayLike, poses: int) -> "GraspTable":
        """From probabilities (m, n); raises InvalidInput where one is outside [0, 1] or the shape differs."""
        names = unique_names("grasp", names)
        scores = finite_array("scores", probabilities, (len(names), poses))
        if (scores < 0.0).any() or (scores > 1.0).any():
            raise InvalidInput("scores", "probabilities from 0 to 1", f"{scores.min():g} to {scores.max():g}")
        return cls(names, scores)

    @classmethod
    def of_successes(cls, names: Sequence[str], successes: ArrayLike, attempts: int, poses: int) -> "GraspTable":
        """From successes (m, n) of `attempts`; raises InvalidInput where one is outside 0..attempts."""
        if attempts < 1:
            raise InvalidInput("attempts", "at least 1", str(attempts))
        counts = finite_array("successes", successes, (len(tuple(names)), poses))
        if (counts < 0).any() or (counts > attempts).any() or (counts != np.round(counts)).any():
            raise InvalidInput(
                "successes", f"whole numbers from 0 to {attempts}", f"{counts.min():g} to {counts.max():g}"
            )
        return cls.of_probabilities(names, counts / attempts, poses)

    def reachable(self, names: Sequence[str] | None) -> "GraspTable":
        """The table of the named grasps alone, in its own order; None: all.

        Raises:
            UnknownName, InvalidInput: no such grasp; none named, or one twice.
        """
        if names is None:
            return self
        rows = np.sort(indices("grasp", names, self.names))
        return GraspTable(tuple(self.names[row] for row in rows), frozen(self.scores[rows]))

    def expected_scores(self, belief: Floats) -> Floats:
        """Qbar(x, b) = sum_p b[p] Q[x, p] for every grasp, (m,) (Definition 3)."""
        return self.scores @ belief


@dataclass(frozen=True)
class Choice:
    """A grasp and what it promises: `index` into the table, or None where every grasp scores 0."""

    index: int | None
    expected_score: float


def best_grasp(table: GraspTable, belief: Floats) -> Choice:
    """x* and Qbar*(b) (equation 1): the first listed within 1e-12 of the best; none when the best is 0."""
    return choose(table.expected_scores(belief))


def choose(expected: Floats) -> Choice:
    """`best_grasp` from expected scores (m,)."""
    best = float(expected.max())
    if best <= 0.0:
        return Choice(None, 0.0)
    return Choice(int(np.argmax(expected >= best - TIE)), best)


def ranked(expected: Floats) -> list[int]:
    """Indices of the grasps, best expected score first; those within 1e-12 (rounded) as listed."""
    return [int(index) for index in np.argsort(-np.round(expected / TIE), kind="stable")]


def log_outcome_weights(scores: Floats, success: bool, score_floor: float = 0.0) -> Floats:
    """Logarithms of the weights that an attempt gives the poses: Q[x, p] for a success, else 1 - Q[x, p].

    It assumes that the attempt left the object where it was.

    Args:
        scores: (n,) Q[x, p] of the grasp that was tried.
        success: what came of it.
        score_floor: scores count as at least this and at most 1 less this, so that 0 of 15 and 15 of 15 do not
            rule poses out for good; in [0, 0.5].
    """
    if not 0.0 <= score_floor <= 0.5:
        raise InvalidInput("score_floor", "a number from 0 to 0.5", repr(score_floor))
    held = np.clip(scores, score_floor, 1.0 - score_floor)
    with np.errstate(divide="ignore"):
        return np.log(held if success else 1.0 - held)
