"""The update of a belief by a scan, tau(b, o) (Definition 4), and the policy for scans that fit no pose."""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from voa_core.absence import updated_log_odds
from voa_core.checks import Floats
from voa_core.checks import number as checked
from voa_core.errors import InvalidInput
from voa_core.estimates import Attempts, Estimate
from voa_core.evidence import Evidence
from voa_core.filtering import Belief, condition, mixture, share_equally
from voa_core.grasps import GraspTable
from voa_core.places import Place, index_of_place, log_increment

OnNoMatch = Literal["reject", "nearest"]
OnNothingSeen = Literal["reject", "evidence"]
Reason = Literal["no_beams", "nothing_seen", "bad_fit", "no_match", "nearest"]

NEAREST_SHARE = 0.015


@dataclass(frozen=True)
class UpdatePolicy:
    """Policy of a scenario for scans that do not fit, and for outcomes of grasps.

    Attributes:
        on_no_match: effect of a scan that has weight 0 at every possible pose: it is rejected, or the nearest poses
            share the belief.
        on_nothing_seen: effect of a scan in which too few beams see the object (`evidence.Sight`).
        reject_above_rmsd_mm: largest RMSD of the best fit with which a scan is accepted, millimetres; None: any.
        score_floor: limit of grasp scores in outcomes, see `grasps.log_outcome_weights`.

    Raises:
        InvalidInput: a value is not one of those allowed.
    """

    on_no_match: OnNoMatch = "reject"
    reject_above_rmsd_mm: float | None = None
    score_floor: float = 0.0
    on_nothing_seen: OnNothingSeen = "reject"

    def __post_init__(self) -> None:
        for field, known in (("on_no_match", get_args(OnNoMatch)), ("on_nothing_seen", get_args(OnNothingSeen))):
            if getattr(self, field) not in known:
                raise InvalidInput(field, " or ".join(map(repr, known)), repr(getattr(self, field)))
        if self.reject_above_rmsd_mm is not None:
            checked("reject_above_rmsd_mm", self.reject_above_rmsd_mm, above=0.0)
        if not 0.0 <= self.score_floor <= 0.5:
            raise InvalidInput("score_floor", "a number from 0 to 0.5", repr(self.score_floor))


@dataclass(frozen=True, eq=False)
class Update:
    """Result of one observation.

    Attributes:
        estimate: after the observation; unchanged where that was not accepted.
        accepted: True if the observation counts.
        reason: why it was not accepted, or does not count for the poses; or `nearest`, where the nearest poses share
            the belief.
        log_evidence: ln sum_p b[p] w[p]; None where the belief was not conditioned.
    """

    estimate: Estimate
    accepted: bool
    reason: Reason | None
    log_evidence: float | None

    @property
    def belief(self) -> Belief:
        """Belief after the observation."""
        return self.estimate.belief


def update(belief: Belief, evidence: Evidence, policy: UpdatePolicy) -> Update:
    """Update a belief by a scan that shares its place with no earlier look, tau(b, o), see `update_estimate`."""
    return update_estimate(Estimate.of(belief), evidence, policy)


def update_estimate(estimate: Estimate, evidence: Evidence, policy: UpdatePolicy, number: int = 0) -> Update:
    """Update an estimate by a scan: b'[p] is proportional to b[p] w[p].

    w is the mean weight of the look's place with the look divided by that without it (`places.log_increment`), so that

        b'[p] ~ b0[p] prod_places (1/J) sum_j prod_looks w(o, o~(p, a, delta_j))

    with b0 the belief without the looks. A scan is not accepted if, in this order, it has no beam to compare, does not
    show the object, or its best fit is too bad. Otherwise Bayes' rule applies, or the policy for a scan that no
    possible pose explains. Where absence is considered, a scan that does not show the object, or that no pose explains,
    is accepted and moves the odds of absence alone.

    Args:
        estimate: before the scan.
        evidence: of the scan, with as many copies of each pose as `copies_needed`.
        policy: effect of scans that do not fit.
        number: of the look, to which its place refers.

    Raises:
        ValueError: look and place have different numbers of copies, and neither has one copy.
    """
    if evidence.beams_compared == 0:
        return Update(estimate, False, "no_beams", None)
    index = index_of_place(estimate.places, evidence.viewpoint)
    before = None if index is None else estimate.places[index]
    begun = Place(evidence.viewpoint, (), np.zeros((len(estimate.belief.p), 1))) if before is None else before
    after = begun.with_look(number, evidence.log_copies)
    log_weights = log_increment(before, after, evidence.log_copies)
    if policy.on_nothing_seen == "reject" and evidence.sight.misses_object(estimate.belief.p > 0.0):
        return _without_object(estimate, evidence, log_weights, "nothing_seen")
    fit, limit = evidence.fit_rmsd_mm, policy.reject_above_rmsd_mm
    if limit is not None and fit is not None and fit > limit:
        return Update(estimate, False, "bad_fit", None)
    posterior = condition(estimate.belief, log_weights)
    if posterior is not None:
        moved = _with_absence(estimate, evidence, posterior.log_evidence) or estimate
        return Update(moved.with_place(after, posterior.belief), True, None, posterior.log_evidence)
    if policy.on_no_match == "nearest":
        return Update(estimate.restarted(nearest(evidence.distances)), True, "nearest", None)
    return _without_object(estimate, evidence, log_weights, "no_match")


def copies_needed(estimate: Estimate, evidence: Evidence) -> int:
    """Number of displaced copies of each pose with which a look and its place must be compared.

    It is the larger of both. Where it is more than `evidence.copies` or than the place's, and those are not 1, compare
    the scan again (`Scenario.evidence`), or the place's earlier scans (`Estimate.with_more_copies`).
    """
    index = index_of_place(estimate.places, evidence.viewpoint)
    return evidence.copies if index is None else max(evidence.copies, estimate.places[index].copies)


def _with_absence(estimate: Estimate, evidence: Evidence, log_evidence: float) -> Estimate | None:
    """Move the odds of absence by a scan; None where absence is not considered, or nothing explains the scan."""
    if estimate.log_odds_absent is None:
        return None
    log_odds = updated_log_odds(estimate.log_odds_absent, evidence.log_absent, log_evidence)
    return None if log_odds is None else replace(estimate, log_odds_absent=log_odds)


def _without_object(estimate: Estimate, evidence: Evidence, log_weights: Floats, reason: Reason) -> Update:
    """Refuse a scan that does not show the object; where absence is considered, let it move the odds of that alone."""
    posterior = condition(estimate.belief, log_weights)
    log_evidence = -np.inf if posterior is None else posterior.log_evidence
    moved = _with_absence(estimate, evidence, log_evidence)
    return Update(estimate, False, reason, None) if moved is None else Update(moved, True, reason, None)


def update_by_outcome(belief: Belief, log_weights: Floats) -> Update:
    """Update a belief by the log weights (n,) of `grasps.log_outcome_weights`; an impossible one is not accepted."""
    return _conditioned(Estimate.of(belief), log_weights)


def _conditioned(estimate: Estimate, log_weights: Floats) -> Update:
    posterior = condition(estimate.belief, log_weights)
    if posterior is None:
        return Update(estimate, False, "no_match", None)
    return Update(replace(estimate, belief=posterior.belief), True, None, posterior.log_evidence)


def update_estimate_by_outcome(
    estimate: Estimate,
    table: GraspTable,
    grasp: int,
    success: bool,
    policy: UpdatePolicy,
    *,
    object_moved: float = 0.0,
    start: Estimate | None = None,
) -> Update:
    """Update an estimate by the outcome of a grasp attempt.

    Args:
        estimate: before the attempt.
        table: scores of the grasps.
        grasp: index of the grasp that was tried.
        success: True if the attempt succeeded.
        policy: has the limit of the scores.
        object_moved: probability m that the attempt moved the object. Where it is above 0, the belief becomes (1 - m)
            times itself plus m times the prior, and earlier looks and attempts no longer count.
        start: the estimate before the first observation, which has the prior; needed where `object_moved` is above 0.

    Returns:
        The update; not accepted where no possible pose allows the outcome.

    Raises:
        InvalidInput: `object_moved` is not in [0, 1], or is above 0 without `start`.
    """
    if not 0.0 <= object_moved <= 1.0:
        raise InvalidInput("object_moved", "a number from 0 to 1", repr(object_moved))
    earlier = estimate.attempts_of(grasp)
    log_weights = table.log_outcome_weights(grasp, success, earlier.successes, earlier.failures, policy.score_floor)
    result = _conditioned(estimate, log_weights)
    if not result.accepted:
        return result
    if object_moved > 0.0:
        if start is None:
            raise InvalidInput(
                "start", "the estimate before the first observation, as the object may have moved", "none"
            )
        mixed = mixture(result.belief, start.belief, object_moved)
        return replace(result, estimate=replace(start, belief=mixed))
    counted = Attempts(grasp, earlier.successes + success, earlier.failures + (not success))
    others = tuple(each for each in estimate.attempts if each.grasp != grasp)
    return replace(result, estimate=replace(result.estimate, attempts=(*others, counted)))


def nearest(distances: Floats) -> Belief:
    """Share the belief among the poses whose exp(-d), d (n,) in metres, is within 0.015 of the largest."""
    likeness = np.exp(-distances)
    return share_equally(likeness.max() - likeness <= NEAREST_SHARE)
