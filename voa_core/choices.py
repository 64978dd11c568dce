"""Choice of a grasp after each of many scans, by a product of matrices.

With B = [b * Q^T | b], column q of B^T W^T holds sum_p W[q, p] b[p] Q[x, p] for every grasp x, and the normaliser last.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choice_kernels import choose_after_panels, choose_after_rows
from voa_core.filtering import Belief, condition
from voa_core.grasps import TIE, Choice, GraspTable, best_grasp, choose
from voa_core.kernels import Array
from voa_core.panels import Panels
from voa_core.register_products import PANEL_BYTES, ROWS, version_at_hand
from voa_core.updating import UpdatePolicy, nearest

_BLOCK_BYTES = 16 * 2**20  # with what it is worked out from, four times as much
_GATHER_BELOW = 0.4  # share of poses, or of scans, below which picking them out of kept weights pays
_LARGEST_ERROR = 1e-6  # of a value, from weights that are left out
_FLOAT64, _FLOAT32 = np.dtype(np.float64), np.dtype(np.float32)
_TIE: dict[np.dtype[Any], np.floating] = {_FLOAT64: np.float64(TIE), _FLOAT32: np.float32(1e-6)}
_LEAST_NORM = {_FLOAT64: 1e-200, _FLOAT32: 1e-20}  # normalisers below which weights that count may have been lost


class LookWeights(Protocol):
    """Weights of every pose after each of the scans that a look may give: `samples` scans of each pose, pose-major.

    The scans of exact rankings are the predictions themselves, one of each pose.
    """

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the weights: float64 or float32."""

    @property
    def matrix(self) -> Array | None:
        """All weights, (n * samples, n), where they are kept scan by scan."""

    @property
    def panels(self) -> Panels | None:
        """All weights where they are kept in panels."""

    def all_weights(self, check: Callable[[], None]) -> Panels | None:
        """Compute all weights at once; None: there are too many, or the scans are simulated.

        Args:
            check: called before; an error that it raises ends the computation.
        """

    @property
    def samples(self) -> int:
        """Number of scans of each pose."""

    @property
    def simulated(self) -> bool:
        """True if the scans are drawn from the sensor model, so that the value of a look has a standard error."""

    def weights(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
        """Weights of the poses `columns` after the scans `rows`, each row scaled by a positive number of its own."""

    def most_left_out(self, rows: NDArray[np.intp], columns: NDArray[np.intp], masses: Floats) -> Floats | None:
        """Largest total, (k,), of what may be left out of `weights(rows, columns)`, each pose counted with its mass.

        None: nothing is left out.

        Args:
            rows: scans.
            columns: poses.
            masses: (c,) probabilities of these poses, which sum to at most 1.
        """

    def beliefs(self, rows: NDArray[np.intp], before: Sequence[Belief], policy: UpdatePolicy) -> list[Belief]:
        """Compute the belief after each of the scans `rows` (k,) from the k beliefs before them, in logarithms."""

    def seen_with(self, belief: Belief, policy: UpdatePolicy) -> "LookWeights":
        """Weights with which scans that do not show the object at any pose that `belief` allows change nothing."""


@dataclass(frozen=True, eq=False)
class Chooser:
    """Choice of a grasp after scans, under one belief and one table of grasps.

    Attributes:
        belief: before the scans, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        check: called before each block of weights; an error that it raises ends the computation.
    """

    belief: Belief
    table: GraspTable
    policy: UpdatePolicy
    check: Callable[[], None] = field(repr=False)
    _factors: dict[tuple[np.dtype[Any], bool], "_Factor"] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def before(self) -> Choice:
        """Best grasp before the scans."""
        return best_grasp(self.table, self.belief.p)

    def after_each(
        self, look: LookWeights, rows: NDArray[np.intp], shares: Floats, *, sure: bool
    ) -> tuple[NDArray[np.intp], Floats]:
        """Choose a grasp after each of the scans `rows`, (k,): its index (-1: none) and its expected score.

        An expected score hardly depends on the choice between nearly equal grasps, but the score of the chosen grasp
        at one pose does: with `sure`, choices that the precision of the weights leaves open are repeated in logarithms.
        So are scans, which count with `shares` (k,), of which so much may be left out that a value could change by
        1e-6.
        """
        factor = self._factor(look)
        choices = self._by_products(look, factor, rows)
        doubtful = choices.norms < _LEAST_NORM[look.dtype]
        for some in self._blocks(look, factor, rows):
            left_out = look.most_left_out(rows[some], factor.columns, factor.masses)
            if left_out is not None:
                doubtful[some] |= shares[some] * left_out > 0.5 * _LARGEST_ERROR / len(rows) * choices.norms[some]
        if sure:
            doubtful |= choices.undecided
        if doubtful.any():
            self._repeat_in_logarithms(look, rows, np.flatnonzero(doubtful), choices.chosen, choices.scores)
        return choices.chosen, choices.scores

    def _by_products(self, look: LookWeights, factor: "_Factor", rows: NDArray[np.intp]) -> "Choices":
        """Choose a grasp after each of the scans `rows`, in the precision of the weights."""
        k, is_of_all = len(rows), len(factor.columns) == len(self.belief.p)
        panels = look.panels
        if panels is None and is_of_all and k == look.samples * len(self.belief.p):
            panels = look.all_weights(self.check)
        if panels is not None and is_of_all and k >= _GATHER_BELOW * panels.scans:
            self.check()
            return choices_after(panels, factor.blocks, factor.grasps).part(rows)
        blocks = [
            choices_after(look.weights(rows[some], factor.columns), factor.blocks, factor.grasps)
            for some in self._blocks(look, factor, rows)
        ]
        return blocks[0] if len(blocks) == 1 else Choices(*map(np.concatenate, zip(*blocks, strict=True)))

    def _blocks(self, look: LookWeights, factor: "_Factor", rows: NDArray[np.intp]) -> Iterator[slice]:
        """Slices of the scans `rows` whose weights fit into memory together; `check` is called before each."""
        at_once = max(1, _BLOCK_BYTES // (look.dtype.itemsize * len(factor.columns)))
        if look.matrix is not None and len(factor.columns) == len(self.belief.p) and len(rows) == len(look.matrix):
            at_once = len(rows)  # the kept matrix itself, unless the scans are in another order: nothing is copied
        for start in range(0, len(rows), at_once):
            self.check()
            yield slice(start, start + at_once)

    def _repeat_in_logarithms(
        self,
        look: LookWeights,
        rows: NDArray[np.intp],
        doubtful: NDArray[np.intp],
        chosen: NDArray[np.intp],
        scores: Floats,
    ) -> None:
        """Compute `chosen` and `scores` (k,) of the `doubtful` of the scans `rows` (k,) once more, in logarithms."""
        rows_at_once = max(1, _BLOCK_BYTES // (8 * len(self.belief.p)))
        for start in range(0, len(doubtful), rows_at_once):
            self.check()
            some = doubtful[start : start + rows_at_once]
            for row, after in zip(some, look.beliefs(rows[some], [self.belief] * len(some), self.policy), strict=True):
                choice = choose(self.table.expected_scores(after.p))
                chosen[row] = -1 if choice.index is None else choice.index
                scores[row] = choice.expected_score

    def _factor(self, look: LookWeights) -> "_Factor":
        """Factor by which the weights of a look are multiplied; made once, for it does not depend on the look."""
        kept = look.matrix is not None or look.panels is not None
        key = look.dtype, kept
        if key not in self._factors:
            self._factors[key] = _Factor.of(self.belief.p, self.table, look.dtype, kept=kept)
        return self._factors[key]


@dataclass(frozen=True, eq=False)
class _Factor:
    """Factor B^T = [b * Q^T | b]^T of the matrix product.

    Attributes:
        columns: (c,) poses that take part.
        masses: (c,) their probabilities before the scan.
        blocks: (g, c, ROWS) probability times score of grasp g ROWS + i, and the probabilities after the last grasp.
        grasps: number m of grasps.
    """

    columns: NDArray[np.intp]
    masses: Floats
    blocks: Array
    grasps: int

    @classmethod
    def of(cls, belief: Floats, table: GraspTable, dtype: np.dtype[Any], *, kept: bool) -> "_Factor":
        """Make the factor for a belief (n,); of kept weights all poses take part, unless few of them have mass."""
        columns = np.flatnonzero(belief > 0.0)
        if kept and len(columns) >= _GATHER_BELOW * len(belief):
            columns = np.arange(len(belief))
        masses = belief[columns]
        m = len(table.scores)
        weighted = np.zeros((m // ROWS + 1, ROWS, len(columns)), dtype=dtype)
        flat = weighted.reshape(-1, len(columns))
        flat[:m] = masses * (table.scores if len(columns) == len(belief) else table.scores[:, columns])
        flat[m] = masses
        return cls(columns, masses, np.ascontiguousarray(weighted.transpose(0, 2, 1)), m)


def scans_of(poses: NDArray[np.intp], samples: int) -> NDArray[np.intp]:
    """Rows of the `samples` scans of each of the `poses` (k,) in the weights of a look, (k * samples,)."""
    if samples == 1:
        return poses
    rows: NDArray[np.intp] = (poses[:, None] * samples + np.arange(samples)).reshape(-1)
    return rows


def scores_at(table: GraspTable, grasps: NDArray[np.intp], poses: NDArray[np.intp]) -> Floats:
    """Scores Q[x, p] of pairs of a grasp and a pose, (k,); the grasp -1, which is none, scores 0."""
    return np.where(grasps < 0, 0.0, table.scores[np.maximum(grasps, 0), poses])


class Choices(NamedTuple):
    """Grasps that are best after k scans.

    Attributes:
        chosen: (k,) index of the first listed that is as good as the best; -1 where the best scores 0.
        scores: (k,) expected score of the best, 0 where nothing is left of the normaliser.
        norms: (k,) normaliser, sum_p w[p] b[p].
        undecided: (k,) True where rounding or underflow may have decided: no score is left, or in float32 the best
            score does not differ from the next.
    """

    chosen: NDArray[np.intp]
    scores: Floats
    norms: Array
    undecided: NDArray[np.bool_]

    def part(self, scans: NDArray[np.intp] | slice) -> "Choices":
        """Choices after some of the scans."""
        return Choices(self.chosen[scans], self.scores[scans], self.norms[scans], self.undecided[scans])


def choices_after(weights: Panels | Array, blocks: Array, grasps: int) -> Choices:
    """Choose the best grasp after each of k scans.

    Args:
        weights: of c poses after each scan, in panels or scan by scan (k, c); float64 or float32.
        blocks: (g, c, ROWS) weighted scores of the grasps, see `choice_kernels`; of the same type.
        grasps: number of grasps.
    """
    k = weights.scans if isinstance(weights, Panels) else len(weights)
    width = PANEL_BYTES // blocks.itemsize
    filled = (k + width - 1) // width * width
    choices = Choices(
        np.zeros(filled, np.intp), np.zeros(filled), np.zeros(filled, blocks.dtype), np.zeros(filled, np.bool_)
    )
    close, tie, version = np.zeros(filled, np.bool_), _TIE[blocks.dtype], version_at_hand()
    if isinstance(weights, Panels):
        choose_after_panels(weights.numbers, blocks, grasps, tie, version, *choices, close)
    else:
        choose_after_rows(np.ascontiguousarray(weights), blocks, grasps, tie, version, *choices, close)
    if blocks.dtype == _FLOAT32:
        choices.undecided[close] = True
    return choices.part(slice(k))


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
