"""The table of grasp scores Q[x, p], and the choice of a grasp under a belief."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

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
        attempts: number of attempts behind each score, which is then successes / attempts; None: scores are given.
    """

    names: tuple[str, ...]
    scores: Floats
    attempts: int | None = None

    @cached_property
    def score_variances(self) -> Floats | None:
        """Variances (m, n) of scores that were measured as k successes of N attempts; None for given probabilities.

        The score has the Beta distribution of parameters k + 1/2 and N - k + 1/2 (Jeffreys).
        """
        if self.attempts is None:
            return None
        a, b = self.attempts * self.scores + 0.5, self.attempts * (1.0 - self.scores) + 0.5
        return frozen(a * b / ((a + b) ** 2 * (a + b + 1.0)))

    @classmethod
    def of_probabilities(cls, names: Sequence[str], probabilities: ArrayLike, poses: int) -> "GraspTable":
        """Make a table from probabilities (m, n); raises InvalidInput for another shape or a value outside [0, 1]."""
        names = unique_names("grasp", names)
        scores = finite_array("scores", probabilities, (len(names), poses))
        if (scores < 0.0).any() or (scores > 1.0).any():
            raise InvalidInput("scores", "probabilities from 0 to 1", f"{scores.min():g} to {scores.max():g}")
        return cls(names, scores)

    @classmethod
    def of_successes(cls, names: Sequence[str], successes: ArrayLike, attempts: int, poses: int) -> "GraspTable":
        """Make a table from numbers of successes (m, n) among `attempts`; raises InvalidInput for one out of range."""
        if attempts < 1:
            raise InvalidInput("attempts", "at least 1", str(attempts))
        counts = finite_array("successes", successes, (len(tuple(names)), poses))
        if (counts < 0).any() or (counts > attempts).any() or (counts != np.round(counts)).any():
            raise InvalidInput(
                "successes", f"whole numbers from 0 to {attempts}", f"{counts.min():g} to {counts.max():g}"
            )
        return replace(cls.of_probabilities(names, counts / attempts, poses), attempts=attempts)

    def reachable(self, names: Sequence[str] | None) -> "GraspTable":
        """Table of the named grasps alone, in the order of this table; None: all grasps.

        Raises:
            UnknownName: there is no such grasp.
            InvalidInput: no grasp is named, or one twice.
        """
        if names is None:
            return self
        rows = np.sort(indices("grasp", names, self.names))
        return GraspTable(tuple(self.names[row] for row in rows), frozen(self.scores[rows]), self.attempts)

    def expected_scores(self, belief: Floats) -> Floats:
        """Expected score of every grasp, Qbar(x, b) = sum_p b[p] Q[x, p] (Definition 3), (m,)."""
        return self.scores @ belief

    def log_outcome_weights(
        self, grasp: int, success: bool, successes: int = 0, failures: int = 0, score_floor: float = 0.0
    ) -> Floats:
        """Logarithms of the weights of the poses after an attempt of a grasp, (n,).

        Scores from k successes of N attempts are uncertain themselves: under Jeffreys' prior the attempt succeeds with
        probability (k + 1/2) / (N + 1), and repeated attempts follow the Beta-binomial distribution: each outcome
        counts among the attempts of its (grasp, pose) cell. Given probabilities weigh as they are.

        Args:
            grasp: index of the grasp that was tried.
            success: True if the attempt succeeded.
            successes, failures: outcomes of earlier attempts of this grasp, with the object where it is.
            score_floor: limit, in [0, 0.5], by which scores are kept away from 0 and from 1.

        Raises:
            InvalidInput: `score_floor` is not in [0, 0.5].
        """
        scores = self.scores[grasp]
        if self.attempts is not None:
            counted = np.round(scores * self.attempts) + successes
            scores = (counted + 0.5) / (self.attempts + successes + failures + 1.0)
        return log_outcome_weights(scores, success, score_floor)


@dataclass(frozen=True)
class Choice:
    """A chosen grasp: its `index` in the table, None where every grasp scores 0, and its expected score."""

    index: int | None
    expected_score: float


def best_grasp(table: GraspTable, belief: Floats) -> Choice:
    """Choose the best grasp under a belief (n,): x* and Qbar*(b) of equation 1.

    It is the first listed whose expected score is within 1e-12 of the largest; none where the largest is 0.
    """
    return choose(table.expected_scores(belief))


def choose(expected: Floats) -> Choice:
    """Choose the first grasp whose expected score, of (m,), is within 1e-12 of the largest; none if that is 0."""
    best = float(expected.max())
    if best <= 0.0:
        return Choice(None, 0.0)
    return Choice(int(np.argmax(expected >= best - TIE)), best)


def ranked(expected: Floats) -> list[int]:
    """Rank grasps by expected score (m,), the best first, equal ones (within 1e-12) as listed: their indices."""
    return [int(index) for index in np.argsort(-np.round(expected / TIE), kind="stable")]


def log_outcome_weights(scores: Floats, success: bool, score_floor: float = 0.0) -> Floats:
    """Logarithms of the weights of the poses after a grasp attempt, (n,): Q[x, p] after a success, else 1 - Q[x, p].

    The attempt is assumed to have left the object where it was.

    Args:
        scores: (n,) Q[x, p] of the grasp that was tried.
        success: True if the attempt succeeded.
        score_floor: limit, in [0, 0.5], by which scores are kept away from 0 and from 1, so that 0 of 15 and 15 of 15
            successes do not rule poses out for good.

    Raises:
        InvalidInput: `score_floor` is not in [0, 0.5].
    """
    if not 0.0 <= score_floor <= 0.5:
        raise InvalidInput("score_floor", "a number from 0 to 0.5", repr(score_floor))
    held = np.clip(scores, score_floor, 1.0 - score_floor)
    with np.errstate(divide="ignore"):
        return np.log(held if success else 1.0 - held)
