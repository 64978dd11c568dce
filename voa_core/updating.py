"""The belief update tau(b, o) (Definition 4), with what happens when a scan says nothing or fits nothing."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from voa_core.checks import Floats, number
from voa_core.errors import InvalidInput
from voa_core.evidence import Evidence
from voa_core.filtering import Belief, condition, share_equally

OnNoMatch = Literal["reject", "nearest"]
Reason = Literal["no_match", "no_beams", "bad_fit", "nearest"]

NEAREST_SHARE = 0.015


@dataclass(frozen=True)
class UpdatePolicy:
    """What a scenario wants done with scans that do not fit.

    Attributes:
        on_no_match: what a scan does to which every possible pose gives weight 0.
        reject_above_rmsd_mm: a scan whose best fit is worse than this is not accepted; None: any is.
        score_floor: for grasp outcomes, see `grasps.log_outcome_weights`.
    """

    on_no_match: OnNoMatch = "reject"
    reject_above_rmsd_mm: float | None = None
    score_floor: float = 0.0

    def __post_init__(self) -> None:
        if self.on_no_match not in get_args(OnNoMatch):
            raise InvalidInput("on_no_match", " or ".join(map(repr, get_args(OnNoMatch))), repr(self.on_no_match))
        if self.reject_above_rmsd_mm is not None:
            number("reject_above_rmsd_mm", self.reject_above_rmsd_mm, above=0.0)
        if not 0.0 <= self.score_floor <= 0.5:
            raise InvalidInput("score_floor", "a number from 0 to 0.5", repr(self.score_floor))


@dataclass(frozen=True, eq=False)
class Update:
    """The outcome of one observation.

    Attributes:
        belief: after it; the one before, where it was not accepted.
        accepted: whether it counts.
        reason: why not, or `nearest` where the belief was shared out instead of conditioned.
        log_evidence: ln sum_p b[p] w[p]; None where nothing was conditioned.
    """

    belief: Belief
    accepted: bool
    reason: Reason | None
    log_evidence: float | None


def update(belief: Belief, evidence: Evidence, policy: UpdatePolicy) -> Update:
    """tau(b, o): no beams, then a bad fit, then Bayes' rule, then the policy for a scan that nothing explains."""
    if evidence.beams_compared == 0:
        return Update(belief, False, "no_beams", None)
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
    """The belief after a grasp attempt, from `grasps.log_outcome_weights`; not accepted if it was impossible."""
    posterior = condition(belief, log_weights)
    if posterior is None:
        return Update(belief, False, "no_match", None)
    return Update(posterior.belief, True, None, posterior.log_evidence)


def nearest(distances: Floats) -> Belief:
    """Equal shares over all poses whose exp(-d) lies within 0.015 of the best one's (the lab's evaluation)."""
    likeness = np.exp(-distances)
    return share_equally(likeness.max() - likeness <= NEAREST_SHARE)
