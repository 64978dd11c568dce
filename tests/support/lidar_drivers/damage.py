"""Faults of the way between lidar and topic, on top of what a driver published."""

import math
from dataclasses import replace

import numpy as np

from voa_ros.messages import LaserScan

PACKET_BEAMS = 6
"""Beams of one packet of an LDS-01."""


def lost_packets(scan: LaserScan, share: float, rng: np.random.Generator, zero: float = 0.0) -> LaserScan:
    """Lose whole packets of 6 neighbouring beams.

    Args:
        scan: a revolution.
        share: of the packets, exactly so many (rounded) are lost; which, `rng` says.
        rng: where the choice comes from.
        zero: what the driver leaves in the place of a lost beam.
    """
    packets = math.ceil(len(scan.ranges) / PACKET_BEAMS)
    lost = set(rng.choice(packets, size=round(share * packets), replace=False).tolist())
    return replace(
        scan,
        ranges=tuple(zero if i // PACKET_BEAMS in lost else value for i, value in enumerate(scan.ranges)),
    )


def flicker(scan: LaserScan, share: float, rng: np.random.Generator, value: float = math.inf) -> LaserScan:
    """Let single beams give no answer, others in each call.

    Args:
        scan: a revolution.
        share: of the beams, exactly so many (rounded) give none; which, `rng` says.
        rng: where the choice comes from.
        value: what the driver says of such a beam.
    """
    beams = len(scan.ranges)
    silent = set(rng.choice(beams, size=round(share * beams), replace=False).tolist())
    return replace(scan, ranges=tuple(value if i in silent else given for i, given in enumerate(scan.ranges)))
