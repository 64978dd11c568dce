"""The belief update tau(b, o) (Definition 4), with what happens when a scan says nothing or fits nothing."""

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
    """What a scenario wants done with scans that do not fit.

    Attributes:
        on_no_match: what a scan does to which every possible pose gives weight 0.
        on_nothing_seen: what a scan does in which too few beams see the object, see `evidence.Sight`.
        reject_above_rmsd_mm: a scan whose best fit is worse than this is not accepted; None: any is.
        score_floor: for grasp outcomes, see `grasps.log_outcome_weights`.
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
    """The belief after a scan, tau(b, o).

    Not accepted, in this order: a scan without a beam to compare, one in which the object is not, and one whose best
    fit is too bad. Then Bayes' rule holds, or the policy for a scan that no possible pose explains.
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
    """The belief after a grasp attempt, from `grasps.log_outcome_weights`; not accepted if it was impossible."""
    posterior = condition(belief, log_weights)
    if posterior is None:
        return Update(belief, False, "no_match", None)
    return Update(posterior.belief, True, None, posterior.log_evidence)


def nearest(distances: Floats) -> Belief:
    """Equal shares over all poses whose exp(-d) lies within 0.015 of the best one's (the lab's evaluation)."""
    likeness = np.exp(-distances)
    return share_equally(likeness.max() - likeness <= NEAREST_SHARE)
