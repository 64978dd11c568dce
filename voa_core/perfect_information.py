"""Perfect information: the most that looks can be expected to gain."""

import numpy as np

from voa_core.checks import Floats
from voa_core.choices import Chooser, LookWeights, scans_of, scores_at


def value_of_perfect_information(chooser: Chooser, outer: Floats, pending: LookWeights | None) -> float:
    """Gain in success probability if the pose were known: sum_p s[p] max_x Q[x, p] - sum_p s[p] Q[x*(b), p].

    No looks can be expected to gain more, whatever their number.

    Args:
        chooser: belief of the gripper agent, and its grasps.
        outer: belief s of the sensor agent, (n,), for the expectation.
        pending: weights after scans that are on their way; the grasp without the knowledge is then chosen after them.
    """
    table, outcomes = chooser.table, np.flatnonzero(outer > 0.0)
    shares = outer[outcomes]
    known = float(shares @ table.scores[:, outcomes].max(axis=0))
    samples = 1 if pending is None else pending.samples
    if pending is None:
        index = chooser.before.index
        chosen = np.full(len(outcomes), -1 if index is None else index)
    else:
        look = pending.seen_with(chooser.belief, chooser.policy)
        rows, of_scans = scans_of(outcomes, samples), np.repeat(shares, samples) / samples
        chosen = chooser.after_each(look, rows, of_scans, sure=True)[0]
    without = scores_at(table, chosen, np.repeat(outcomes, samples)).reshape(-1, samples).mean(axis=1)
    return known - float(shares @ without)
