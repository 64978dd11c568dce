"""Value of Assistance: how much a look is expected to raise the probability of a successful grasp.

`posterior` (equations 2 and 3 of the preliminary paper):
    VOA(a, b) = sum_p s[p] Qbar*(b_p) - Qbar*(b),                b_p = tau(b, o~(p, a))
`executed` (equation 4 of the longer paper):
    VOA(a, b) = sum_p s[p] (Q[x*(b_p), p] - Q[x*(b), p])

with s the belief of the sensor agent (equation 3 of the longer paper), the gripper agent's own b by default.
Over simulated scans each pose p gives K scans o_pk instead of o~(p, a), and the mean over them stands for its term.
A VOA may be negative and is never clamped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import LookWeights, after_each
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, best_grasp
from voa_core.updating import UpdatePolicy
from voa_core.weights import wanted

Definition = Literal["posterior", "executed"]


@dataclass(frozen=True, eq=False)
class Assistance:
    """Value of one look, and the grasps that would be chosen after it.

    Attributes:
        voa: expected gain in success probability.
        expected_score_after: expected success probability after the look.
        outcomes: (k,) indices of the poses to which the sensor agent gives a probability above 0.
        best_grasps: (k,) the grasp chosen most often after the scans of each, the first listed of equals; -1 for none.
        scores: (k,) expected score of the chosen grasp then, Qbar*(b_p), the mean over the scans.
        shares: (k,) probabilities that the sensor agent gives to these poses.
        gains: (k, K) gain in success probability after each of the K scans of each pose.
        standard_error: of `voa`, from the number of simulated scans; None over exact scans.
        score_standard_error: of `voa`, from the number of attempts behind the grasp scores; None where that is unknown.
    """

    voa: float
    expected_score_after: float
    outcomes: NDArray[np.intp]
    best_grasps: NDArray[np.intp]
    scores: Floats
    shares: Floats
    gains: Floats
    standard_error: float | None = None
    score_standard_error: float | None = None


def value_of_assistance(
    look: LookWeights,
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    definition: Definition = "posterior",
    sensor_belief: Belief | None = None,
    pending: LookWeights | None = None,
    check: Callable[[], None] = wanted,
) -> Assistance:
    """Value of Assistance of a look whose weights are given.

    Args:
        look: weights of every pose after each scan that the look may give. With `pending` they are those of the pending
            scans and the look's together, sample by sample.
        belief: of the gripper agent, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        definition: "posterior" (equations 2 and 3 of the preliminary paper) or "executed" (equation 4 of the longer).
        sensor_belief: of the sensor agent, (n,), for the outer expectation; None: the gripper agent's.
        pending: weights after scans that are on their way and not known yet; the value is what the look adds to them.
        check: called before each block of weights; an error that it raises ends the computation.

    Raises:
        InvalidInput: there is no such definition.
    """
    if definition not in get_args(Definition):
        raise InvalidInput("definition", " or ".join(map(repr, get_args(Definition))), repr(definition))
    outer = (belief if sensor_belief is None else sensor_belief).p
    outcomes = np.flatnonzero(outer > 0.0)
    shares = outer[outcomes]
    shape = len(outcomes), look.samples
    rows = outcomes if look.samples == 1 else scans_of(outcomes, look.samples)
    poses = np.repeat(outcomes, look.samples)
    executed = definition == "executed"
    look = look.seen_with(belief, policy)
    of_scans = np.repeat(shares, look.samples) / look.samples
    chosen, scores = after_each(look, rows, of_scans, belief, table, policy, sure=executed, check=check)
    values = scores_at(table, chosen, poses) if executed else scores
    before = best_grasp(table, belief.p)
    kept = np.full(len(rows), -1 if before.index is None else before.index)
    base = scores_at(table, kept, poses) if executed else np.full(len(rows), before.expected_score)
    if pending is not None:
        pending = pending.seen_with(belief, policy)
        kept, pending_scores = after_each(pending, rows, of_scans, belief, table, policy, sure=executed, check=check)
        base = scores_at(table, kept, poses) if executed else pending_scores
    after = float(shares @ values.reshape(shape).mean(axis=1))
    without = (
        float(shares @ base.reshape(shape).mean(axis=1)) if executed or pending is not None else before.expected_score
    )
    gains = (values - base).reshape(shape)
    return Assistance(
        after - without,
        after,
        outcomes,
        _most_frequent(chosen.reshape(shape)),
        scores.reshape(shape).mean(axis=1),
        shares,
        gains,
        standard_error(shares, gains) if look.simulated else None,
        _score_standard_error(table, chosen, kept, poses, of_scans),
    )


def scans_of(poses: NDArray[np.intp], samples: int) -> NDArray[np.intp]:
    """Rows of the `samples` scans of each of the `poses` (k,) in the weights of a look, (k * samples,)."""
    rows: NDArray[np.intp] = (poses[:, None] * samples + np.arange(samples)).reshape(-1)
    return rows


def scores_at(table: GraspTable, grasps: NDArray[np.intp], poses: NDArray[np.intp]) -> Floats:
    """Scores Q[x, p] of pairs of a grasp and a pose, (k,); the grasp -1, which is none, scores 0."""
    return np.where(grasps < 0, 0.0, table.scores[np.maximum(grasps, 0), poses])


def standard_error(shares: Floats, gains: Floats) -> float:
    """Standard error of the mean gain of a look over simulated scans.

    Its square is sum_p s[p]^2 Var_k / K, with the variance over the K scans of a pose. With one scan of each pose it is
    sum_p s[p]^2 (g_p - mean g)^2, with the mean weighted by s: the poses stand for each other's scans.

    K scans that agree do not show that all scans do: a look that fails once in a thousand scans would have no error at
    all. So, as in Laplace's rule of succession, the variance counts one scan more over all poses, after which nothing
    is gained: s[p] of it at pose p. A look that never gains anything keeps the error 0.

    Args:
        shares: (k,) probabilities s[p] of the poses.
        gains: (k, K) gain after each scan of each pose.
    """
    samples = gains.shape[1]
    if samples == 1:
        total = shares.sum()
        mean = float(shares @ gains[:, 0]) / (total if total > 0.0 else 1.0)
        return float(np.sqrt(np.sum((shares * (gains[:, 0] - mean)) ** 2)))
    means = gains.sum(axis=1) / (samples + shares)
    squares = np.sum((gains - means[:, None]) ** 2, axis=1) + shares * means**2
    return float(np.sqrt(np.sum(shares**2 * squares / (samples - 1 + shares)) / samples))


def _most_frequent(chosen: NDArray[np.intp]) -> NDArray[np.intp]:
    """Grasp that is chosen most often in each row of (k, K), the first listed of equals."""
    if chosen.shape[1] == 1:
        return chosen[:, 0]
    return np.array([int(np.bincount(row + 1).argmax()) - 1 for row in chosen], dtype=np.intp)


def score_variances(table: GraspTable) -> Floats | None:
    """Variances (m, n) of grasp scores that were measured as k successes of N attempts; None for given probabilities.

    The score has the Beta distribution of parameters k + 1/2 and N - k + 1/2 (Jeffreys).
    """
    if table.attempts is None:
        return None
    a, b = table.attempts * table.scores + 0.5, table.attempts * (1.0 - table.scores) + 0.5
    variances: Floats = a * b / ((a + b) ** 2 * (a + b + 1.0))
    return variances


def _score_standard_error(
    table: GraspTable,
    chosen: NDArray[np.intp],
    kept: NDArray[np.intp],
    poses: NDArray[np.intp],
    shares: Floats,
) -> float | None:
    """Standard deviation of a VOA whose grasps stay chosen while the true scores vary about the measured ones.

    The executed value is linear in the scores: each cell counts by how much oftener the look has its grasp chosen at
    its pose. So no scores need be drawn.

    Args:
        table: the grasps; None is returned where its scores are given probabilities.
        chosen, kept: (k,) grasp after each scan with the look and without it; -1 for none.
        poses: (k,) pose that gives the scan.
        shares: (k,) probability of the scan.
    """
    variances = score_variances(table)
    if variances is None:
        return None
    difference = np.zeros_like(variances)
    for grasps, sign in ((chosen, 1.0), (kept, -1.0)):
        some = grasps >= 0
        np.add.at(difference, (grasps[some], poses[some]), sign * shares[some])
    return float(np.sqrt(np.sum(difference**2 * variances)))


def executed_value(before: Belief, after_each: list[Belief], table: GraspTable) -> float:
    """AECD: sum_p b[p] Qbar*(b after the scan that was measured at p) - Qbar*(b).

    The posterior form over scans really measured: what the look was worth, where VOA says what it should be.

    Args:
        before: (n,).
        after_each: one belief per pose, after the scan measured at that pose.
        table: the grasps that are reachable.
    """
    after = [best_grasp(table, belief.p).expected_score for belief in after_each]
    return float(before.p @ np.array(after)) - best_grasp(table, before.p).expected_score
