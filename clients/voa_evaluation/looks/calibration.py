"""Calibration: looks binned by what they should be worth, against what they were worth on average."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import Interval, bootstrap_ratio

EDGES = (-1.0, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0)
"""Of the bins, in success probability: from and including the lower, below the upper."""


@dataclass(frozen=True)
class Bin:
    """Looks whose VOA lies between two edges.

    Attributes:
        voa: their mean VOA.
        achieved: their mean achieved value, resampled by drop; `count` counts looks.
        drops: that have such a look.
    """

    kind: Belief
    rule: str
    low: float
    high: float
    voa: float
    achieved: Interval
    drops: int


def calibration(rows: Rows, seed: int) -> list[Bin]:
    """By kind and rule over all objects; bins without a look are left out."""
    return [
        found
        for kind in rows.kinds
        for rule in rows.rules
        for found in _bins(rows.of(kind=kind, rule=rule), kind, rule, seed)
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
