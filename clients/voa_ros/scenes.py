"""Difference of two scans, by which a robot without a measured pose is recognised to stand still.

Only differences of ranges indicate motion. Beams that return intermittently do not: many lidars lose packets, and
report +inf or 0 for a dark or slanted surface in one revolution and its range in the next.
"""

import math
import statistics
from collections.abc import Sequence

from voa_ros.scans import beam_class

NOISE_M = 0.02
"""Constant part of the tolerance `NOISE_M + NOISE_SHARE * range` for two scans of the same scene, metres."""
NOISE_SHARE = 0.04
"""Part of the tolerance `NOISE_M + NOISE_SHARE * range` that grows with the range."""
CLEARLY = 2.0
"""Difference, in units of the tolerance, above which the scene has clearly changed."""
APPEARED_SHARE = 0.6
"""Change of the share of returns, among returns and no-returns, above which the scene has changed."""


def scene_difference(one: Sequence[float], other: Sequence[float]) -> float:
    """Compute the difference of two scans with the same beams, in units of the tolerance for scans of one scene.

    The difference is the median of `|a - b| / (NOISE_M + NOISE_SHARE * min(a, b))` over the beams that return in both
    scans, and 0 where there is no such beam. It is infinite where the share of returns, among returns and no-returns,
    differs by more than `APPEARED_SHARE`: when a robot leaves a room, for instance. Zeros count as neither, because an
    LDS-01 reports them for lost packets too.

    Args:
        one: ranges of the first scan, metres, with the special values of LaserScans.
        other: ranges of the second scan, one per beam of the first.

    Returns:
        The difference; at most 1 for two scans of one scene.

    Raises:
        ValueError: the numbers of beams differ.
    """
    apart = [
        abs(a - b) / (NOISE_M + NOISE_SHARE * min(a, b))
        for a, b in zip(one, other, strict=True)
        if beam_class(a) == beam_class(b) == "return"
    ]
    here, there = _share_of_returns(one), _share_of_returns(other)
    if here is not None and there is not None and abs(here - there) > APPEARED_SHARE:
        return math.inf
    return statistics.median(apart) if apart else 0.0


def _share_of_returns(ranges: Sequence[float]) -> float | None:
    """Share of returns among the returns and no-returns; None: there is neither."""
    classes = [beam_class(value) for value in ranges]
    returns, nothing = classes.count("return"), classes.count("nothing")
    return returns / (returns + nothing) if returns + nothing else None
