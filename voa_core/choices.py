"""Choice of a grasp after each of many scans, by one matrix product per block of scans."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.filtering import Belief, condition
from voa_core.grasps import TIE, GraspTable, choose
from voa_core.kernels import Array, choose_each
from voa_core.updating import UpdatePolicy, nearest

_BLOCK_BYTES = 16 * 2**20  # with what it is worked out from, four times as much
_GATHER_BELOW = 0.4  # share of poses with mass below which picking them out of a kept matrix pays
_LEAST_NORM = {"float64": 1e-200, "float32": 1e-20}
_LARGEST_ERROR = 1e-6  # of a value, from weights that are left out
_TIE = {"float64": TIE, "float32": 1e-6}


class LookWeights(Protocol):
    """Weights of every pose after each of the scans that a look may give: `samples` scans of each pose, pose-major.

    The scans of exact rankings are the predictions themselves, one of each pose.
    """

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the weights: float64 or float32."""

    @property
    def matrix(self) -> Array | None:
        """All weights, (n * samples, n), where they are kept."""

    @property
    def samples(self) -> int:
        """Number of scans of each pose."""

    @property
    def simulated(self) -> bool:
        """True if the scans are drawn from the sensor model, so that the value of a look has a standard error."""

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Weights of the poses `columns` after the scans `rows`, each row scaled by a positive number of its own."""

    def most_left_out(self, rows: NDArray[np.intp], columns: NDArray[np.intp], masses: Floats) -> Floats:
        """Largest total, (k,), of what may be left out of `weights(rows, columns)`, each pose counted with its mass.

        Args:
            rows: scans.
            columns: poses.
            masses: (c,) probabilities of these poses, which sum to at most 1.
        """

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after each of the scans `rows` (k,) from the k beliefs before them, in logarithms."""

    def seen_with(self, belief: Belief, policy: UpdatePolicy) -> "LookWeights":
        """Weights with which scans that do not show the object at any pose that `belief` allows change nothing."""


def after_each(
    look: LookWeights,
    rows: NDArray[np.intp],
    shares: Floats,
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    sure: bool,
    check: Callable[[], None],
) -> tuple[NDArray[np.intp], Floats]:
    """Choose a grasp after each of the scans `rows`, (k,): its index (-1: none) and its expected score.

    An expected score hardly depends on the choice between nearly equal grasps, but the score of the chosen grasp at
    one pose does: with `sure`, choices that the precision of the weights leaves open are repeated in logarithms. So are
    scans, which count with `shares` (k,), of which so much may be left out that a value could change by 1e-6.

    One matrix product per block: with B = [b * Q^T | b], column q of B^T W^T holds sum_p W[q, p] b[p] Q[x, p] for
    every grasp, and its last entry the normaliser.
    """
    columns = np.flatnonzero(belief.p > 0.0)
    if look.matrix is not None and len(columns) >= _GATHER_BELOW * len(belief.p):
        columns = np.arange(len(belief.p))
    masses = belief.p[columns]
    right = np.zeros((len(table.scores) + 1, len(columns)), dtype=look.dtype)
    right[:-1] = masses * (table.scores if len(columns) == len(belief.p) else table.scores[:, columns])
    right[-1] = masses
    chosen = np.zeros(len(rows), dtype=np.intp)
    scores = np.zeros(len(rows))
    doubtful = np.zeros(len(rows), dtype=bool)
    rows_at_once = max(1, _BLOCK_BYTES // (look.dtype.itemsize * len(columns)))
    if look.matrix is not None and len(columns) == len(belief.p) and len(rows) == len(look.matrix):
        rows_at_once = len(rows)  # the kept matrix itself: nothing is copied
    for start in range(0, len(rows), rows_at_once):
        check()
        block = slice(start, start + rows_at_once)
        product = right @ look.weights(rows[block], columns).T
        left_out = look.most_left_out(rows[block], columns, masses)
        chosen[block], scores[block], undecided = _choose_each(product)
        again = product[-1] < _LEAST_NORM[look.dtype.name]
        again |= shares[block] * left_out > 0.5 * _LARGEST_ERROR / len(rows) * product[-1]
        doubtful[block] = again | undecided if sure else again
    again_rows = np.flatnonzero(doubtful)
    rows_at_once = max(1, _BLOCK_BYTES // (8 * len(belief.p)))
    for start in range(0, len(again_rows), rows_at_once):
        check()
        some = again_rows[start : start + rows_at_once]
        for row, after in zip(some, look.beliefs(rows[some], [belief] * len(some), policy), strict=True):
            choice = choose(table.expected_scores(after.p))
            chosen[row] = -1 if choice.index is None else choice.index
            scores[row] = choice.expected_score
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


def belief_after(belief: Belief, log_weights: Floats, policy: UpdatePolicy, distances: Callable[[], Floats]) -> Belief:
    """Compute the belief after a scan with these log weights (n,), in logarithms.

    Args:
        belief: before the scan.
        log_weights: ln w of each pose.
        policy: effect of a scan that no possible pose explains.
        distances: gives the distance of the scan to each pose, (n,) metres, where the policy needs it.
    """
    posterior = condition(belief, log_weights)
    if posterior is not None:
        return posterior.belief
    return nearest(distances()) if policy.on_no_match == "nearest" else belief
