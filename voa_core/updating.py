"""The update of a belief by a scan, tau(b, o) (Definition 4), and the policy for scans that fit no pose."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from voa_core.checks import Floats, number
from voa_core.errors import InvalidInput
from voa_core.evidence import Evidence
from voa_core.filtering import Belief, condition, share_equally

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
            number("reject_above_rmsd_mm", self.reject_above_rmsd_mm, above=0.0)
        if not 0.0 <= self.score_floor <= 0.5:
            raise InvalidInput("score_floor", "a number from 0 to 0.5", repr(self.score_floor))


@dataclass(frozen=True, eq=False)
class Update:
    """Result of one observation.

    Attributes:
        belief: after the observation; unchanged where that was not accepted.
        accepted: True if the observation counts.
        reason: why it was not accepted; or `nearest`, where the nearest poses share the belief.
        log_evidence: ln sum_p b[p] w[p]; None where the belief was not conditioned.
    """

    belief: Belief
    accepted: bool
    reason: Reason | None
    log_evidence: float | None


def update(belief: Belief, evidence: Evidence, policy: UpdatePolicy) -> Update:
    """Update a belief by a scan, tau(b, o).

    A scan is not accepted if, in this order, it has no beam to compare, does not show the object, or its best fit is
    too bad. Otherwise Bayes' rule applies, or the policy for a scan that no possible pose explains.
    """
    if evidence.beams_compared == 0:
        return Update(belief, False, "no_beams", None)
    if policy.on_nothing_seen == "reject" and evidence.sight.misses_object(belief.p > 0.0):
        return Update(belief, False, "nothing_seen", None)
    fit, limit = evidence.fit_rmsd_mm, policy.reject_above_rmsd_mm
    if limit is not None and fit is not None and fit > limit:
        return Update(belief, False, "bad_fit", None)
    posterior = condition(belief, evidence.log_weights)
    if posterior is not None:
        return Update(posterior.belief, True, None, posterior.log_evidence)
    if policy.on_no_match == "nearest":
        return Update(nearest(evidence.distances), True, "nearest", None)
    return Update(belief, False, "no_match", None)


def update_by_outcome(belief: Belief, log_weights: Floats) -> Update:
    """Update a belief by the log weights (n,) of `grasps.log_outcome_weights`; an impossible one is not accepted."""
    posterior = condition(belief, log_weights)
    if posterior is None:
        return Update(belief, False, "no_match", None)
    return Update(posterior.belief, True, None, posterior.log_evidence)


def nearest(distances: Floats) -> Belief:
    """Share the belief among the poses whose exp(-d), d (n,) in metres, is within 0.015 of the largest."""
    likeness = np.exp(-distances)
    return share_equally(likeness.max() - likeness <= NEAREST_SHARE)
