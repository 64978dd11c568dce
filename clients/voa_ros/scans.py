"""ROS 2's scans as the contract's, and many revolutions as one.

What a beam says (REP-117, and what drivers make of it):

| in the LaserScan            | here      | in the contract's scan                                     |
|-----------------------------|-----------|------------------------------------------------------------|
| finite, above 0             | `return`  | its range, rounded to a micrometre (it was a float32)      |
| +inf                        | `nothing` | its index in `no_return`                                   |
| 0                           | `zero`    | 0: the scenario's lidar says what that means               |
| NaN, -inf, finite below 0   | `missing` | null                                                       |
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

from voa_msgs.base import MOST
from voa_msgs.sessions import Scan
from voa_ros.messages import LaserScan, Stamp

GRID_WITHIN_RAD = 1e-4
"""The contract's: beams that differ by more are others."""
_DIGITS = 6


Beam = Literal["return", "nothing", "zero", "missing"]


def beam_class(value: float) -> Beam:
    """What a beam says; see the table above."""
    if value == 0.0:
        return "zero"
    if value == math.inf:
        return "nothing"
    return "return" if value > 0.0 else "missing"


def same_grid(one: LaserScan, other: LaserScan) -> bool:
    """Whether two scans have the same beams: as many, and none turned by more than 1e-4 rad."""
    last = len(one.ranges) - 1
    first_off = one.angle_min - other.angle_min
    last_off = first_off + last * (one.angle_increment - other.angle_increment)
    return len(one.ranges) == len(other.ranges) and max(abs(first_off), abs(last_off)) <= GRID_WITHIN_RAD


def stamp_json(stamp: Stamp) -> dict[str, Any]:
    """`{"sec", "nanosec"}`, as ROS 2 has it."""
    return {"sec": stamp.sec, "nanosec": stamp.nanosec}


def scan_message(scan: LaserScan, stamp: dict[str, Any] | None = None) -> Scan:
    """The contract's scan. Any LaserScan gives one; whether a service takes so many beams is the service's to say.

    Limits are carried over where the driver set them: a `range_max` that is 0, infinite or not above `range_min`
    says nothing, and the scenario's lidar holds.

    Args:
        scan: a revolution, or the median of several.
        stamp: free JSON to keep with the scan; None: the message's own stamp and frame.
    """
    classes = [beam_class(value) for value in scan.ranges]
    limits: dict[str, float] = {}
    near, far = round(scan.range_min, _DIGITS), round(scan.range_max, _DIGITS)
    if near < far <= MOST:
        limits = {"range_min": near, "range_max": far}
    return Scan(
        ranges=[
            _rounded(value) if beam in ("return", "zero") else None
            for value, beam in zip(scan.ranges, classes, strict=True)
        ],
        no_return=[index for index, beam in enumerate(classes) if beam == "nothing"],
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        stamp={**stamp_json(scan.stamp), "frame_id": scan.frame_id} if stamp is None else stamp,
        **limits,
    )


def _rounded(value: float) -> float:
    """To a micrometre, but a return never becomes a zero; without the sign of -0."""
    return round(value, _DIGITS) or abs(value)


def median_scan(scans: Sequence[LaserScan]) -> LaserScan:
    """Many revolutions of a lidar that stands still as one: each beam by itself.

    A beam that gave no answer (zero or missing) in more than half of the revolutions gave none: 0 where most of those
    were zeros, else NaN. In the others no answer was a lost packet, and the rest decide: most of them returns, the
    median of those; most of them +inf, +inf; a tie is a beam on an edge, NaN, no evidence. The LDS-01 has one 0
    for a lost packet and for nothing in range: the first hits six beams of a revolution now and then, the second
    the same beams in all of them. An even number of returns gives the lower of the two in the middle: a range
    that was measured, where the mean of two could lie in the air between an edge and the wall behind it.

    Args:
        scans: at least one, all with the same beams.

    Returns:
        A scan with stamp, frame, times and limits of the first, and no intensities.

    Raises:
        ValueError: there is none, or their beams differ.
    """
    if not scans:
        raise ValueError("expected at least one scan")
    first = scans[0]
    for scan in scans:
        if not same_grid(first, scan):
            raise ValueError(
                f"expected scans with the same beams, got {len(first.ranges)} from {first.angle_min} by "
                f"{first.angle_increment} and {len(scan.ranges)} from {scan.angle_min} by {scan.angle_increment}"
            )
    beams = zip(*(scan.ranges for scan in scans), strict=True)
    return replace(first, ranges=tuple(_median_beam(values) for values in beams), intensities=())


def _median_beam(values: Sequence[float]) -> float:
    classes = [beam_class(value) for value in values]
    zeros, missing = classes.count("zero"), classes.count("missing")
    if 2 * (zeros + missing) > len(values):
        return 0.0 if zeros >= missing else math.nan
    returns = [value for value, beam in zip(values, classes, strict=True) if beam == "return"]
    nothing = classes.count("nothing")
    if len(returns) == nothing:
        return math.nan
    return statistics.median_low(returns) if len(returns) > nothing else math.inf
