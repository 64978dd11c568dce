"""Calibration: looks in bins of their Value of Assistance, against the value that they achieved on average."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import Interval, bootstrap_ratio

EDGES = (-1.0, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0)
"""Edges of the bins, in success probability; a bin includes its lower edge."""


@dataclass(frozen=True)
class Bin:
    """Looks whose VOA lies between two edges.

    Attributes:
        kind: of the belief.
        rule: name of the update rule.
        low, high: edges of the bin.
        voa: mean VOA of the looks.
        achieved: mean achieved value of the looks, resampled by drop; `count` counts looks.
        drops: number of drops that have such a look.
    """

    kind: Belief
    rule: str
    low: float
    high: float
    voa: float
    achieved: Interval
    drops: int


def calibration(rows: Rows, seed: int) -> list[Bin]:
    """Compute the bins for each kind of belief and update rule over all objects; empty bins are left out."""
    return [
        each
        for kind in rows.kinds
        for rule in rows.rules
        for each in _bins(rows.of(kind=kind, rule=rule), kind, rule, seed)
    ]


def _bins(group: Rows, kind: Belief, rule: str, seed: int) -> list[Bin]:
    voa = np.array([[look.voa for look in row.looks] for row in group.rows])
    achieved = group.achieved()
    bins = []
    for low, high in pairwise(EDGES):
        inside = (voa >= low) & (voa < high)
        if not inside.any():
            continue
        counts = inside.sum(axis=1).astype(np.float64)
        gained = np.where(inside, achieved, 0.0).sum(axis=1)
        interval = bootstrap_ratio(gained, counts, seed)
        bins.append(Bin(kind, rule, low, high, float(voa[inside].mean()), interval, int((counts > 0).sum())))
    return bins
