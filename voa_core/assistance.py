"""Value of Assistance: how much a look is expected to raise the probability of a successful grasp.

`posterior` (equations 2 and 3 of the preliminary paper):
    VOA(a, b) = sum_p s[p] Qbar*(b_p) - Qbar*(b),                b_p = tau(b, o~(p, a))
`executed` (equation 4 of the longer paper):
    VOA(a, b) = sum_p s[p] (Q[x*(b_p), p] - Q[x*(b), p])

with s the belief of the sensor agent (equation 3 of the longer paper), the gripper agent's own b by default.
Over simulated scans each pose p gives K scans o_pk instead of o~(p, a), and the mean over them stands for its term.
Over a sample of the poses, the sum over p is one over the sampled poses with their shares; b_p and the baseline of the
posterior form still come from all poses, so the value is unbiased.
A VOA may be negative and is never clamped.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.choices import Chooser, LookWeights, scans_of, scores_at
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, best_grasp
from voa_core.perfect_information import value_of_perfect_information
from voa_core.pose_samples import PoseSample
from voa_core.standard_errors import score_standard_error, standard_error
from voa_core.updating import UpdatePolicy
from voa_core.weights import wanted

Definition = Literal["posterior", "executed"]


@dataclass(frozen=True, eq=False)
class Assistance:
    """Value of one look, and the grasps that would be chosen after it.

    Attributes:
        voa: expected gain in success probability.
        expected_score_after: expected success probability after the look.
        outcomes: (k,) indices of the poses to which the sensor agent gives a probability above 0, or of sampled ones.
        best_grasps: (k,) the grasp chosen most often after the scans of each, the first listed of equals; -1 for none.
        scores: (k,) expected score of the chosen grasp then, Qbar*(b_p), the mean over the scans.
        shares: (k,) probabilities that the sensor agent gives to these poses, or the shares of sampled ones.
        gains: (k, K) gain in success probability after each of the K scans of each pose.
        standard_error: of `voa`, from the number of simulated scans or of sampled poses; None over exact scans of all
            poses.
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


@dataclass(frozen=True, eq=False)
class Valuation:
    """Belief, grasps and definition by which looks are valued.

    Attributes:
        belief: of the gripper agent, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        definition: "posterior" (equations 2 and 3 of the preliminary paper) or "executed" (equation 4 of the longer).
        sensor_belief: of the sensor agent, (n,), for the outer expectation; None: the gripper agent's.
        sample: poses over which the outer expectation is taken; None: all of them.
        check: called before each block of weights; an error that it raises ends the computation.

    Raises:
        InvalidInput: there is no such definition.
    """

    belief: Belief
    table: GraspTable
    policy: UpdatePolicy
    definition: Definition = "posterior"
    sensor_belief: Belief | None = None
    sample: PoseSample | None = None
    check: Callable[[], None] = field(default=wanted, repr=False)

    def __post_init__(self) -> None:
        if self.definition not in get_args(Definition):
            raise InvalidInput("definition", " or ".join(map(repr, get_args(Definition))), repr(self.definition))

    def value(self, look: LookWeights, pending: LookWeights | None = None) -> Assistance:
        """Value of Assistance of a look.

        Args:
            look: weights of every pose after each scan that the look may give. With `pending` they are those of the
                pending scans and the look's together, sample by sample.
            pending: weights after scans that are on their way and not known yet; the value is what the look adds.
        """
        scans = self._scans(look.samples)
        chosen, scores = self._chosen(look, scans)
        executed = self.definition == "executed"
        values = scores_at(self.table, chosen, scans.poses) if executed else scores
        kept, base, without = scans.kept, scans.base, scans.without
        if pending is not None:
            kept, pending_scores = self._chosen(pending, scans)
            base = scores_at(self.table, kept, scans.poses) if executed else pending_scores
            without = scans.mean(base)
        voa = scans.mean(values) - without
        gains = (values - base).reshape(-1, look.samples)
        return Assistance(
            voa,
            scans.mean(values) if self.sample is None or pending is not None else self._without + voa,
            scans.outcomes,
            _most_frequent(chosen.reshape(-1, look.samples)),
            scores if look.samples == 1 else scores.reshape(-1, look.samples).mean(axis=1),
            scans.shares,
            gains,
            self._standard_error(scans, gains, simulated=look.simulated),
            score_standard_error(self.table, chosen, kept, scans.poses, scans.of_scores),
        )

    def perfect_information(self, pending: LookWeights | None) -> float:
        """Value of knowing the pose, after the pending scans."""
        outer = self.outer if self.sample is None or pending is None else self.sample.over(len(self.outer))
        return value_of_perfect_information(self._chooser, outer, pending)

    def _chosen(self, look: LookWeights, scans: "_Scans") -> tuple[NDArray[np.intp], Floats]:
        look = look.seen_with(self.belief, self.policy)
        return self._chooser.after_each(look, scans.rows, scans.of_scans, sure=self.definition == "executed")

    @cached_property
    def _chooser(self) -> Chooser:
        return Chooser(self.belief, self.table, self.policy, self.check)

    @property
    def outer(self) -> Floats:
        """Belief over which the outer expectation is taken, (n,)."""
        return (self.belief if self.sensor_belief is None else self.sensor_belief).p

    @cached_property
    def _without(self) -> float:
        """Expected success probability without a look, over all poses."""
        before = self._chooser.before
        if self.definition == "posterior" or before.index is None:
            return before.expected_score
        return float(self.table.scores[before.index] @ self.outer)

    def _standard_error(self, scans: "_Scans", gains: Floats, *, simulated: bool) -> float | None:
        if self.sample is not None:
            return self.sample.standard_error(gains.mean(axis=1))
        return standard_error(scans.shares, gains) if simulated else None

    def _scans(self, samples: int) -> "_Scans":
        """Scans that a look may give; made once, for they do not depend on the look."""
        if samples not in self._scans_by_samples:
            self._scans_by_samples[samples] = self._make_scans(samples)
        return self._scans_by_samples[samples]

    def _make_scans(self, samples: int) -> "_Scans":
        if self.sample is None:
            outcomes = np.flatnonzero(self.outer > 0.0)
            shares = self.outer[outcomes]
            return _Scans.of(outcomes, shares, shares, samples, self._chooser, self.definition)
        sample = self.sample
        return _Scans.of(sample.poses, sample.shares, sample.cell_weights, samples, self._chooser, self.definition)

    @cached_property
    def _scans_by_samples(self) -> "dict[int, _Scans]":
        return {}


@dataclass(frozen=True, eq=False)
class _Scans:
    """Scans that a look may give, and the grasp that is best without them.

    Attributes:
        samples: number K of scans of each pose.
        outcomes: (k,) indices of the poses over which the expectation is taken.
        shares: (k,) their probabilities, or their shares in a sample.
        rows: (k K,) rows of the scans in the weights of a look.
        poses: (k K,) pose that gives each scan.
        of_scans: (k K,) probability of each scan.
        of_scores: (k K,) weight of the score that is attained after each scan in the error of the value.
        kept: (k K,) grasp that is chosen without the look; -1 for none.
        base: (k K,) its value, by the definition of the valuation.
        without: expected success probability without the look.
    """

    samples: int
    outcomes: NDArray[np.intp]
    shares: Floats
    rows: NDArray[np.intp]
    poses: NDArray[np.intp]
    of_scans: Floats
    of_scores: Floats
    kept: NDArray[np.intp]
    base: Floats
    without: float

    @classmethod
    def of(
        cls,
        outcomes: NDArray[np.intp],
        shares: Floats,
        of_scores: Floats,
        samples: int,
        chooser: Chooser,
        definition: Definition,
    ) -> "_Scans":
        """Make the scans of a look, `samples` of each of the poses `outcomes`, (k,), with `shares` and `of_scores`."""
        rows, poses = scans_of(outcomes, samples), np.repeat(outcomes, samples)
        before = chooser.before
        kept = np.full(len(rows), -1 if before.index is None else before.index)
        executed = definition == "executed"
        base = scores_at(chooser.table, kept, poses) if executed else np.full(len(rows), before.expected_score)
        of_scans, of_scores = (np.repeat(each, samples) / samples for each in (shares, of_scores))
        scans = cls(samples, outcomes, shares, rows, poses, of_scans, of_scores, kept, base, 0.0)
        return replace(scans, without=scans.mean(base) if executed else before.expected_score)

    def mean(self, values: Floats) -> float:
        """Expectation of a value that each scan has, (k K,)."""
        return float(self.shares @ (values if self.samples == 1 else values.reshape(-1, self.samples).mean(axis=1)))


def value_of_assistance(
    look: LookWeights,
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    definition: Definition = "posterior",
    sensor_belief: Belief | None = None,
    pending: LookWeights | None = None,
) -> Assistance:
    """Value of Assistance of one look; see `Valuation`, which values many under one belief.

    Args:
        look: weights of every pose after each scan that the look may give, those of `pending` included.
        belief: of the gripper agent, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        definition: "posterior" or "executed".
        sensor_belief: of the sensor agent, (n,), for the outer expectation; None: the gripper agent's.
        pending: weights after scans that are on their way and not known yet.

    Raises:
        InvalidInput: there is no such definition.
    """
    return Valuation(belief, table, policy, definition, sensor_belief).value(look, pending)


def _most_frequent(chosen: NDArray[np.intp]) -> NDArray[np.intp]:
    """Grasp that is chosen most often in each row of (k, K), the first listed of equals."""
    if chosen.shape[1] == 1:
        return chosen[:, 0]
    return np.array([int(np.bincount(row + 1).argmax()) - 1 for row in chosen], dtype=np.intp)


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
