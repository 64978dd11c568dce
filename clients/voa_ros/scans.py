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
from voa_ros.grids import BeamGrid, binned, on_grid, same_grid, with_limits_of
from voa_ros.messages import LaserScan, Stamp

_DIGITS = 6


Beam = Literal["return", "nothing", "zero", "missing"]


def beam_class(value: float) -> Beam:
    """What a beam says; see the table above."""
    if value == 0.0:
        return "zero"
    if value == math.inf:
        return "nothing"
    return "return" if value > 0.0 else "missing"


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


def median_scan(scans: Sequence[LaserScan], grid: BeamGrid) -> LaserScan:
    """Many revolutions of a lidar that stands still as one scan: each beam by itself.

    Where the revolutions have the same beams these are kept; where they differ, all are brought onto `grid` first, and
    a beam of the grid is decided by the revolutions that reached it. See `_median_beam` for how.

    Args:
        scans: at least one.
        grid: that of the scenario's lidar.

    Returns:
        A scan with stamp, frame and times of the first, the widest limits, and no intensities.

    Raises:
        ValueError: there is none.
    """
    if not scans:
        raise ValueError("expected at least one scan")
    first = with_limits_of(scans)
    if all(same_grid(first, scan) for scan in scans):
        beams = zip(*(scan.ranges for scan in scans), strict=True)
        return replace(first, ranges=tuple(_median_beam(values) for values in beams), intensities=())
    reached = zip(*(binned([scan], grid) for scan in scans), strict=True)
    ranges = tuple(_median_beam([value for value in values if value is not None]) for values in reached)
    return replace(on_grid([first], grid), ranges=ranges)


def _median_beam(values: Sequence[float]) -> float:
    """One beam of many revolutions; NaN of none.

    A beam that gave no answer (zero or missing) in more than half of the revolutions gave none: 0 where most of those
    were zeros, else NaN. In the others no answer was a lost packet, and the rest decide. At least half of them returns:
    the median of those, since a dark or slanted surface answers in every second revolution only. Less than a quarter:
    +inf, nothing is there but now and then a stray return. Between the two it is a beam on an edge: NaN, no evidence.
    The LDS-01 writes the same 0 for a lost packet and for nothing in range: the first hits six beams of a revolution
    now and then, the second the same beams in all of them. An even number of returns gives the lower of the two in the
    middle: a range that was measured, where the mean of two could lie in the air between an edge and the wall behind.
    """
    classes = [beam_class(value) for value in values]
    zeros, missing = classes.count("zero"), classes.count("missing")
    if not values or 2 * (zeros + missing) > len(values):
        return 0.0 if zeros >= missing and values else math.nan
    returns = [value for value, beam in zip(values, classes, strict=True) if beam == "return"]
    answers = len(returns) + classes.count("nothing")
    if 2 * len(returns) >= answers:
        return statistics.median_low(returns)
    return math.inf if 4 * len(returns) < answers else math.nan


def laser_scan(scan: Scan, grid: BeamGrid) -> LaserScan:
    """A LaserScan with the beams of a contract's scan, without times and limits.

    Args:
        scan: its beams, by the table above read backwards.
        grid: of the scenario's lidar, for angles that the scan does not say.
    """
    nothing = set(scan.no_return)
    ranges = tuple(
        math.inf if index in nothing else math.nan if value is None else value
        for index, value in enumerate(scan.ranges)
    )
    first = grid.angle_min if scan.angle_min is None else scan.angle_min
    apart = grid.angle_increment if scan.angle_increment is None else scan.angle_increment
    return LaserScan(Stamp(), "", first, first + (len(ranges) - 1) * apart, apart, 0.0, 0.0, 0.0, 0.0, ranges)
