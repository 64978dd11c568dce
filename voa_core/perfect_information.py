"""Perfect information: the most that looks can be expected to gain."""

from collections.abc import Callable

import numpy as np

from voa_core.assistance import scans_of, scores_at
from voa_core.choices import LookWeights, after_each
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable, best_grasp
from voa_core.updating import UpdatePolicy
from voa_core.weights import wanted


def value_of_perfect_information(
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    sensor_belief: Belief | None = None,
    pending: LookWeights | None = None,
    check: Callable[[], None] = wanted,
) -> float:
    """Gain in success probability if the pose were known: sum_p s[p] max_x Q[x, p] - sum_p s[p] Q[x*(b), p].

    No looks can be expected to gain more, whatever their number.

    Args:
        belief: of the gripper agent, (n,).
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        sensor_belief: of the sensor agent, (n,), for the expectation; None: the gripper agent's.
        pending: weights after scans that are on their way; the grasp without the knowledge is then chosen after them.
        check: called before each block of weights; an error that it raises ends the computation.
    """
    outer = (belief if sensor_belief is None else sensor_belief).p
    outcomes = np.flatnonzero(outer > 0.0)
    known = float(outer[outcomes] @ table.scores[:, outcomes].max(axis=0))
    samples = 1 if pending is None else pending.samples
    if pending is None:
        index = best_grasp(table, belief.p).index
        chosen = np.full(len(outcomes), -1 if index is None else index)
    else:
        look = pending.seen_with(belief, policy)
        rows, shares = scans_of(outcomes, samples), np.repeat(outer[outcomes], samples) / samples
        chosen = after_each(look, rows, shares, belief, table, policy, sure=True, check=check)[0]
    without = scores_at(table, chosen, np.repeat(outcomes, samples)).reshape(-1, samples).mean(axis=1)
    return known - float(outer[outcomes] @ without)
