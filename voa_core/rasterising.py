"""Ranges of the beams from the contours of the object, by a one-dimensional z-buffer over the beams.

Every contour point gets one beam coordinate (its angle in units of the beam spacing), shared by the segments
that meet there. A segment covers the beams of the half-open interval between its ends' coordinates, so
neighbouring segments neither both cover a beam nor leave one out. The point at which a beam meets the segment is exact.

Most segments lie between two beams. Coordinates of points are computed first, in loops that run in vector registers;
then a comparison of integers selects the few segments that cover a beam.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.cutting import Contours
from voa_core.jit import kernel, sum_kernel
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.outlines import Ints
from voa_core.scans import NO_RETURN


def rasterise(contours: Contours, sensor: SensorConfiguration, grid: BeamGrid, range_max: float) -> Floats:
    """Compute the ranges that a lidar at `sensor` measures for every pose.

    Returns:
        Shape (n, r) float64, metres; inf for a beam without a hit within `range_max`. A hit nearer than the
        lidar's `range_min` counts as a hit: the object is there.
    """
    ranges = np.full((len(contours.cut_of_pose), grid.beams), NO_RETURN)
    # A lidar that turns clockwise sees the mirrored world counter-clockwise.
    mirror = 1.0 if grid.angle_increment > 0.0 else -1.0
    cosines, sines = directions(grid, mirror)
    _rasterise(
        contours.points,
        contours.segments,
        contours.point_start,
        contours.segment_start,
        contours.cut_of_pose,
        contours.placement,
        np.array([sensor.x, sensor.y, math.cos(sensor.yaw_rad), math.sin(sensor.yaw_rad), mirror]),
        cosines,
        sines,
        mirror * grid.angle_min,
        abs(grid.angle_increment),
        range_max,
        ranges,
    )
    return ranges


@lru_cache(maxsize=16)
def directions(grid: BeamGrid, mirror: float) -> tuple[Floats, Floats]:
    """Cosines and sines of the beams' angles, (r,) each: kept, because a lidar's beams do not change."""
    angles = mirror * grid.angles
    return frozen(np.cos(angles)), frozen(np.sin(angles))


# atan(t) / t as a polynomial in t^2 for |t| <= tan(pi / 8), by Chebyshev interpolation; the error of the
# angle is below 1e-14 rad. tests/voa_core/test_rasterising.py derives the coefficients again.
ATAN = (
    0.9999999999999718,
    -0.33333333330739956,
    0.1999999959830251,
    -0.14285690138924959,
    0.11110378784989745,
    -0.09078316021748097,
    0.07563186422294492,
    -0.05872662369410048,
    0.030635630925872032,
)
EDGE_ON_BEAMS = 1e-9  # a segment that spans less has its nearer end in front; where a beam meets it is rounding
_TINY = 1e-300
_TAN_EIGHTH = math.tan(math.pi / 8.0)


@sum_kernel
def angle(y: float, x: float) -> float:
    """atan2(y, x) in (-pi, pi] without branches, so that a loop over points runs in vector registers."""
    ax, ay = abs(x), abs(y)
    small, large = min(ax, ay), max(ax, ay)
    folded = small > _TAN_EIGHTH * large
    t = (small - large if folded else small) / (small + large if folded else max(large, _TINY))
    u = t * t
    p = ATAN[8]
    p = p * u + ATAN[7]
    p = p * u + ATAN[6]
    p = p * u + ATAN[5]
    p = p * u + ATAN[4]
    p = p * u + ATAN[3]
    p = p * u + ATAN[2]
    p = p * u + ATAN[1]
    p = p * u + ATAN[0]
    a = p * t
    a = a + 0.25 * math.pi if folded else a
    a = 0.5 * math.pi - a if ay > ax else a
    a = math.pi - a if x < 0.0 else a
    return -a if y < 0.0 else a


@kernel
def _rasterise(
    points: Floats,
    segments: Ints,
    point_start: NDArray[np.int64],
    segment_start: NDArray[np.int64],
    cut_of_pose: NDArray[np.int64],
    placement: Floats,
    sensor: Floats,
    cosines: Floats,
    sines: Floats,
    angle_min: float,
    spacing: float,
    range_max: float,
    ranges: Floats,
) -> None:
    most = 0
    for cut in range(len(point_start) - 1):
        most = max(most, point_start[cut + 1] - point_start[cut])
    xs, ys, us = np.zeros(most), np.zeros(most), np.zeros(most)
    cells = np.zeros(most, dtype=np.int32)
    for pose in range(len(cut_of_pose)):
        cut = cut_of_pose[pose]
        outline = points[point_start[cut] : point_start[cut + 1]]
        joined = segments[segment_start[cut] : segment_start[cut + 1]]
        n = len(outline)
        _place(outline, placement[pose], sensor, xs[:n], ys[:n])
        _aim(xs[:n], ys[:n], angle_min, spacing, us[:n], cells[:n])
        _cover(joined, xs, ys, us, cells, cosines, sines, spacing, range_max, ranges[pose])


@sum_kernel
def _place(outline: Floats, placement: Floats, sensor: Floats, xs: Floats, ys: Floats) -> None:
    """Transform the points (q, 2) of a cut to the sensor's frame, mirrored for a lidar that turns clockwise."""
    c, s = placement[0], placement[1]
    tx, ty = placement[2] - sensor[0], placement[3] - sensor[1]
    xx, xy = sensor[2] * c + sensor[3] * s, sensor[3] * c - sensor[2] * s
    x0, y0 = sensor[2] * tx + sensor[3] * ty, sensor[2] * ty - sensor[3] * tx
    mirror = sensor[4]
    for i in range(len(outline)):
        xs[i] = xx * outline[i, 0] + xy * outline[i, 1] + x0
        ys[i] = mirror * (xx * outline[i, 1] - xy * outline[i, 0] + y0)


@sum_kernel
def _aim(xs: Floats, ys: Floats, angle_min: float, spacing: float, us: Floats, cells: Ints) -> None:
    """Compute the beam coordinate of each point, in [0, turn), and the beam before it.

    A bearing slightly clockwise of beam 0 may round to a whole turn: it then counts as that of beam 0.
    """
    turn = 2.0 * math.pi / spacing  # beams in one turn, in general not a whole number
    beams_per_rad = 1.0 / spacing
    start = beams_per_rad * (angle_min - 2.0 * math.pi * math.floor(angle_min / (2.0 * math.pi) + 0.5))
    for i in range(len(us)):  # two loops: one for both would not run in vector registers
        us[i] = angle(ys[i], xs[i])
    for i in range(len(us)):
        u = us[i] * beams_per_rad - start
        u = u + turn if u < 0.0 else u
        u = u - turn if u >= turn else u
        us[i] = u
        cells[i] = np.int32(u)


@kernel
def _cover(
    joined: Ints,
    xs: Floats,
    ys: Floats,
    us: Floats,
    cells: Ints,
    cosines: Floats,
    sines: Floats,
    spacing: float,
    range_max: float,
    row: Floats,
) -> None:
    """Enter the segments (g, 2) of one contour into the ranges (r,) of one scan.

    In every turn of the grid the coordinate of a point is computed by one formula for all its segments, so that exactly
    one of two segments that meet in a point covers a beam there.
    """
    turn = 2.0 * math.pi / spacing
    last = len(row) - 1
    for g in _candidates(joined, cells, last, turn):
        i, j = joined[g, 0], joined[g, 1]
        if us[i] > us[j]:
            i, j = j, i
        first = 0
        if us[j] - us[i] > 0.5 * turn:  # the short way round leads through beam 0
            i, j, first = j, i, -1
        if xs[i] * ys[j] == xs[j] * ys[i]:
            continue
        lap = 0
        while us[i] + (lap + first) * turn < last:
            low, high = us[i] + (lap + first) * turn, us[j] + lap * turn
            for k in range(max(math.floor(low) + 1, 0), min(math.floor(high), last) + 1):
                # Both ends in the beam's own frame: how far along it, and how far to its left.
                along_i, left_i = cosines[k] * xs[i] + sines[k] * ys[i], cosines[k] * ys[i] - sines[k] * xs[i]
                along_j, left_j = cosines[k] * xs[j] + sines[k] * ys[j], cosines[k] * ys[j] - sines[k] * xs[j]
                share = left_i / (left_i - left_j) if left_i < min(left_j, 0.0) else 0.0
                r = max(along_i + min(share, 1.0) * (along_j - along_i), 0.0)
                if high - low < EDGE_ON_BEAMS:
                    r = min(along_i, along_j)
                row[k] = min(row[k], r if r <= range_max else math.inf)
            lap += 1


@kernel
def _candidates(joined: Ints, cells: Ints, last: int, turn: float) -> Ints:
    """Select the segments that may cover a beam: not those with both ends between the same two beams.

    In a grid of more than one turn, beams of later turns point between those of the first, and in one of two beams
    or less both ends may follow the same beam on different sides: then any segment may.
    """
    any_may = last > turn or turn <= 2.0
    candidates = np.zeros(len(joined), dtype=np.int32)
    count = 0
    for g in range(len(joined)):  # without a branch, which a processor could not predict
        candidates[count] = g
        count += any_may | (cells[joined[g, 0]] != cells[joined[g, 1]])
    return candidates[:count]
