"""Whether two scans show one scene: how a robot whose pose nobody measures is seen to stand still.

Only ranges tell motion. Beams that answer now and then do not: many lidars lose packets, and write +inf or 0 for a
dark or slanted surface in one revolution and its range in the next.
"""

import math
import statistics
from collections.abc import Sequence

from voa_ros.scans import beam_class

NOISE_M = 0.02
NOISE_SHARE = 0.04
"""Of the range. Two scans of one scene differ by less than `NOISE_M + NOISE_SHARE * range`, in the median."""
CLEARLY = 2.0
"""A scene is clearly another one when it differs by as many times what two scans of one scene may."""
APPEARED_SHARE = 0.6
"""Of the beams that answered: where the share of returns rises or falls by more, the scene is another one."""


def scene_difference(one: Sequence[float], other: Sequence[float]) -> float:
    """Difference of two scans of the same beams, in units of what two scans of one scene may differ by.

    The median over the beams that return in both of `|a - b| / (NOISE_M + NOISE_SHARE * min(a, b))`; 0 where there is
    no such beam. Infinite where the share of returns among the beams that answered (returned, or reported that nothing
    is in range) differs by more than `APPEARED_SHARE`: from a room into the open, for instance. Zeros are no answer:
    an LDS-01 writes them for lost packets too.

    Args:
        one: ranges as LaserScans have them.
        other: as many.

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
    """Returns among the beams that answered; None: none of them did."""
    classes = [beam_class(value) for value in ranges]
    returns, nothing = classes.count("return"), classes.count("nothing")
    return returns / (returns + nothing) if returns + nothing else None
