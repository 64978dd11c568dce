"""Value of Assistance: how much a look is expected to raise the probability of a successful grasp.

`posterior` (equations 2 and 3 of the preliminary paper):
    VOA(a, b) = sum_p s[p] Qbar*(b_p) - Qbar*(b),                b_p = tau(b, o~(p, a))
`executed` (equation 4 of the longer paper):
    VOA(a, b) = sum_p s[p] (Q[x*(b_p), p] - Q[x*(b), p])

with s the belief of the sensor agent (equation 3 of the longer paper), the gripper agent's own b by default.
A VOA may be negative and is never clamped.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief, condition
from voa_core.grasps import TIE, GraspTable, best_grasp, choose
from voa_core.kernels import Array, choose_each
from voa_core.updating import UpdatePolicy, nearest
from voa_core.weights import Weigher, wanted

Definition = Literal["posterior", "executed"]

_BLOCK_BYTES = 16 * 2**20  # with what it is worked out from, four times as much
_GATHER_BELOW = 0.4  # share of poses with mass below which picking them out of a kept matrix pays
_LEAST_NORM = {"float64": 1e-200, "float32": 1e-20}
_TIE = {"float64": TIE, "float32": 1e-6}


@dataclass(frozen=True, eq=False)
class Assistance:
    """Value of one look, and the grasps that would be chosen after it.

    Attributes:
        voa: expected gain in success probability.
        expected_score_after: expected success probability after the look.
        outcomes: (k,) indices of the poses to which the sensor agent gives a probability above 0.
        best_grasps: (k,) the grasp chosen after the scan predicted for each; -1 for none.
        scores: (k,) expected score of that grasp then, Qbar*(b_p).
    """

    voa: float
    expected_score_after: float
    outcomes: NDArray[np.intp]
    best_grasps: NDArray[np.intp]
    scores: Floats


def value_of_assistance(
    weigher: Weigher,
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    definition: Definition = "posterior",
    sensor_belief: Belief | None = None,
    check: Callable[[], None] = wanted,
) -> Assistance:
    """Value of Assistance of a look from the sensor configuration whose weights `weigher` holds.

    Args:
        weigher: weights between the scans predicted there.
        belief: of the gripper agent, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        definition: "posterior" (equations 2 and 3 of the preliminary paper) or "executed" (equation 4 of the longer).
        sensor_belief: of the sensor agent, (n,), for the outer expectation; None: the gripper agent's.
        check: called before each block of weights; an error that it raises ends the computation.

    Raises:
        InvalidInput: there is no such definition.
    """
    if definition not in get_args(Definition):
        raise InvalidInput("definition", " or ".join(map(repr, get_args(Definition))), repr(definition))
    outer = (belief if sensor_belief is None else sensor_belief).p
    outcomes = np.flatnonzero(outer > 0.0)
    shares = outer[outcomes]
    chosen, scores = _after_each(weigher, outcomes, belief, table, policy, sure=definition == "executed", check=check)
    before = best_grasp(table, belief.p)
    if definition == "posterior":
        after = float(shares @ scores)
        return Assistance(after - before.expected_score, after, outcomes, chosen, scores)
    after = float(shares @ _scored_at(table, chosen, outcomes))
    kept = np.full(len(outcomes), -1 if before.index is None else before.index)
    return Assistance(after - float(shares @ _scored_at(table, kept, outcomes)), after, outcomes, chosen, scores)


def _scored_at(table: GraspTable, grasps: NDArray[np.intp], poses: NDArray[np.intp]) -> Floats:
    """Scores Q[x, p] of pairs of a grasp and a pose, (k,); the grasp -1, which is none, scores 0."""
    return np.where(grasps < 0, 0.0, table.scores[np.maximum(grasps, 0), poses])


def _after_each(
    weigher: Weigher,
    outcomes: NDArray[np.intp],
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    sure: bool,
    check: Callable[[], None],
) -> tuple[NDArray[np.intp], Floats]:
    """Best grasp (-1: none) and its expected score after the scan predicted for each of `outcomes`.

    An expected score hardly depends on the choice between nearly equal grasps, but the score of the chosen grasp at
    one pose does: with `sure`, choices that the precision of the weights leaves open are repeated in logarithms.

    One matrix product per block: with B = [b * Q^T | b], column q of B^T W^T holds sum_p W[q, p] b[p] Q[x, p] for
    every grasp, and its last entry the normaliser.
    """
    columns = np.flatnonzero(belief.p > 0.0)
    if weigher.matrix is not None and len(columns) >= _GATHER_BELOW * len(belief.p):
        columns = np.arange(len(belief.p))
    masses = belief.p[columns]
    right = np.zeros((len(table.scores) + 1, len(columns)), dtype=weigher.dtype)
    right[:-1] = masses * (table.scores if len(columns) == len(belief.p) else table.scores[:, columns])
    right[-1] = masses
    chosen = np.zeros(len(outcomes), dtype=np.intp)
    scores = np.zeros(len(outcomes))
    rows_at_once = max(1, _BLOCK_BYTES // (weigher.dtype.itemsize * len(columns)))
    if weigher.matrix is not None and len(columns) == len(outcomes) == len(belief.p):
        rows_at_once = len(outcomes)  # the kept matrix itself: nothing is copied
    for start in range(0, len(outcomes), rows_at_once):
        check()
        block = slice(start, start + rows_at_once)
        product = right @ weigher.weights(outcomes[block], columns).T
        chosen[block], scores[block], doubtful = _choose_each(product)
        again = product[-1] < _LEAST_NORM[weigher.dtype.name]
        for row in np.flatnonzero(again | doubtful if sure else again):
            chosen[start + row], scores[start + row] = _after_one(
                weigher, int(outcomes[start + row]), belief, table, policy
            )
    return chosen, scores


def _choose_each(product: Array) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
    """Choose a grasp for every column of (m + 1, k) unnormalised expected scores with the normaliser last.

    Returns:
        Index of the chosen grasp (-1: none) and its expected score for each column, (k,), and flags (k,) of the
        columns in which rounding or underflow may have decided: no score is left, or in float32 the best score does
        not differ from the next.
    """
    chosen, tied = np.zeros((2, product.shape[1]), dtype=np.intp)
    best = np.zeros(product.shape[1])
    choose_each(product, _TIE[product.dtype.name], chosen, best, tied)
    norm = product[-1].astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        scores = best / norm
    doubtful = best <= _TIE[product.dtype.name] * norm
    if product.dtype == np.float32:
        doubtful |= tied > 1
    return chosen, scores, doubtful


def _after_one(
    weigher: Weigher, outcome: int, belief: Belief, table: GraspTable, policy: UpdatePolicy
) -> tuple[int, float]:
    """Best grasp (-1: none) and its expected score after one outcome, in logarithms.

    Needed where the weights nearly vanish at every pose that the belief holds possible.
    """
    posterior = condition(belief, weigher.log_row(outcome))
    if posterior is not None:
        after = posterior.belief
    else:
        after = nearest(weigher.distances(outcome)) if policy.on_no_match == "nearest" else belief
    choice = choose(table.expected_scores(after.p))
    return (-1 if choice.index is None else choice.index), choice.expected_score


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
