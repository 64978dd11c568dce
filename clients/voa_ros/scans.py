"""Convert LaserScans to scans of the service and back, and compute the median of several revolutions.

Classes of beams (REP-117, and the habits of drivers):

| in the LaserScan            | class     | in the scan of the service                                 |
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
"""Class of a beam, as the docstring of this module lists them."""


def beam_class(value: float) -> Beam:
    """Classify the range of a beam, metres, by the table in the docstring of this module."""
    if value == 0.0:
        return "zero"
    if value == math.inf:
        return "nothing"
    return "return" if value > 0.0 else "missing"


def stamp_json(stamp: Stamp) -> dict[str, Any]:
    """Convert a stamp to JSON: `{"sec", "nanosec"}`, as in ROS 2."""
    return {"sec": stamp.sec, "nanosec": stamp.nanosec}


def scan_message(scan: LaserScan, stamp: dict[str, Any] | None = None) -> Scan:
    """Convert a LaserScan to a scan of the service; the number of beams is not limited here.

    Range limits are kept where the driver sets them. A `range_max` that is 0, infinite or not above `range_min` is left
    out, and the limits of the scenario's lidar apply.

    Args:
        scan: a revolution, or the median of several.
        stamp: JSON to store with the scan; None: stamp and frame of the message.
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
    """Round to a micrometre without making a return zero; -0 becomes 0."""
    return round(value, _DIGITS) or abs(value)


def median_scan(scans: Sequence[LaserScan], grid: BeamGrid) -> LaserScan:
    """Compute the per-beam median of several revolutions of a lidar that stands still.

    Where all revolutions have the same beams, these are kept. Otherwise all are brought onto `grid` first, and each
    beam of the grid is computed from the revolutions that have a beam near it. `_median_beam` states the rules.

    Args:
        scans: revolutions, at least one.
        grid: grid of the scenario's lidar.

    Returns:
        A scan with stamp, frame and times of the first revolution, the widest limits, and no intensities.

    Raises:
        ValueError: there is no scan.
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
    """Compute the median of one beam over several revolutions; NaN where there are none.

    A beam that is zero or missing in more than half of the revolutions is 0 where most of those are zeros, else NaN.
    Otherwise zeros and missing values are taken for lost packets, and the others decide. If at least half of them are
    returns, the result is the median of the returns, because a dark or slanted surface returns in every second
    revolution only. If less than a quarter are returns, it is +inf: nothing is there but a stray return. In between,
    the beam lies on an edge, and the result is NaN: no evidence. The LDS-01 writes 0 for a lost packet and for nothing
    in range: the first affects six beams of a few revolutions, the second the same beams in all of them. An even number
    of returns gives the lower of the two in the middle: a range that was measured, where the mean of two could lie in
    the air between an edge and the wall behind it.
    """
    classes = [beam_class(value) for value in values]
    zeros, missing = classes.count("zero"), classes.count("missing")
    if not values or 2 * (zeros + missing) > len(values):
        return 0.0 if zeros >= missing and values else math.nan
    returns = [value for value, beam in zip(values, classes, strict=True) if beam == "return"]
    evident = len(returns) + classes.count("nothing")
    if 2 * len(returns) >= evident:
        return statistics.median_low(returns)
    return math.inf if 4 * len(returns) < evident else math.nan


def laser_scan(scan: Scan, grid: BeamGrid) -> LaserScan:
    """Convert a scan of the service to a LaserScan without times and limits.

    Args:
        scan: scan of the service; the table in the docstring of this module is read from right to left.
        grid: grid of the scenario's lidar, for angles that the scan does not state.
    """
    nothing = set(scan.no_return)
    ranges = tuple(
        math.inf if index in nothing else math.nan if value is None else value
        for index, value in enumerate(scan.ranges)
    )
    first = grid.angle_min if scan.angle_min is None else scan.angle_min
    apart = grid.angle_increment if scan.angle_increment is None else scan.angle_increment
    return LaserScan(Stamp(), "", first, first + (len(ranges) - 1) * apart, apart, 0.0, 0.0, 0.0, 0.0, ranges)
