"""From contours to ranges: a one-dimensional z-buffer over the beams.

Every contour point gets one beam coordinate (its angle in units of the beam spacing), shared by the segments
that meet there. A segment covers the beams of the half-open interval between its ends' coordinates, so
neighbouring segments neither both cover a beam nor leave one out. Where a beam meets the segment is exact.
"""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.cutting import Contours, Ints
from voa_core.jit import kernel
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.scans import NO_RETURN


def rasterise(contours: Contours, sensor: SensorConfiguration, grid: BeamGrid, range_max: float) -> Floats:
    """Ranges that a lidar at `sensor` measures for every pose.

    Returns:
        Shape (n, r) float64, metres; inf where nothing is hit within `range_max`. A hit nearer than the
        lidar's `range_min` stays a hit: the object is there.
    """
    ranges = np.full((len(contours.cut_of_pose), grid.beams), NO_RETURN)
    # A lidar that turns clockwise sees the mirrored world counter-clockwise.
    mirror = 1.0 if grid.angle_increment > 0.0 else -1.0
    angles = mirror * grid.angles
    _rasterise(
        contours.points,
        contours.segments,
        contours.point_start,
        contours.segment_start,
        contours.cut_of_pose,
        contours.placement,
        np.array([sensor.x, sensor.y, math.cos(sensor.yaw_rad), math.sin(sensor.yaw_rad), mirror]),
        np.cos(angles),
        np.sin(angles),
        mirror * grid.angle_min,
        abs(grid.angle_increment),
        range_max,
        ranges,
    )
    return ranges


# atan(t) / t as a polynomial in t^2 for |t| <= tan(pi / 8), by Chebyshev interpolation; the error of the
# angle is below 1e-14 rad. tests/voa_core/test_rasterising.py derives the coefficients anew.
_ATAN = (
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
_EDGE_ON_BEAMS = 1e-9  # a segment that spans less has its nearer end in front; where a beam meets it is rounding
_TAN_EIGHTH = math.tan(math.pi / 8.0)


@kernel
def _angle(y: float, x: float) -> float:
    """atan2(y, x) in (-pi, pi] without branches, so that a loop over points runs in vector registers."""
    ax, ay = abs(x), abs(y)
    small, large = min(ax, ay), max(ax, ay)
    t = small / large if large > 0.0 else 0.0
    folded = t > _TAN_EIGHTH
    t = (t - 1.0) / (t + 1.0) if folded else t
    u = t * t
    p = _ATAN[8]
    p = p * u + _ATAN[7]
    p = p * u + _ATAN[6]
    p = p * u + _ATAN[5]
    p = p * u + _ATAN[4]
    p = p * u + _ATAN[3]
    p = p * u + _ATAN[2]
    p = p * u + _ATAN[1]
    p = p * u + _ATAN[0]
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
    turn = 2.0 * math.pi / spacing  # beams in one turn, in general not a whole number
    last = len(cosines) - 1
    one_turn = last <= turn  # else beams of later turns point between those of the first
    most = 0
    for cut in range(len(point_start) - 1):
        most = max(most, point_start[cut + 1] - point_start[cut])
    xs, ys, us = np.zeros(most), np.zeros(most), np.zeros(most)
    for pose in range(len(cut_of_pose)):
        cut = cut_of_pose[pose]
        p0, p1 = point_start[cut], point_start[cut + 1]
        # Cut frame -> world -> sensor frame, mirrored for a lidar that turns clockwise.
        c, s = placement[pose, 0], placement[pose, 1]
        tx, ty = placement[pose, 2] - sensor[0], placement[pose, 3] - sensor[1]
        xx, xy = sensor[2] * c + sensor[3] * s, sensor[3] * c - sensor[2] * s
        x0, y0 = sensor[2] * tx + sensor[3] * ty, sensor[2] * ty - sensor[3] * tx
        mirror = sensor[4]
        for i in range(p1 - p0):
            px, py = points[p0 + i, 0], points[p0 + i, 1]
            x = xx * px + xy * py + x0
            y = mirror * (xx * py - xy * px + y0)
            xs[i], ys[i] = x, y
            u = (_angle(y, x) - angle_min) / spacing
            us[i] = u - turn * math.floor(u / turn)
        for g in range(segment_start[cut], segment_start[cut + 1]):
            i, j = segments[g, 0], segments[g, 1]
            if one_turn and math.floor(us[i]) == math.floor(us[j]) and abs(us[i] - us[j]) < 0.5 * turn:
                continue  # between two beams
            cross = xs[i] * ys[j] - xs[j] * ys[i]
            if cross == 0.0:
                continue
            if cross < 0.0:
                i, j = j, i
            low, high = us[i], us[j]
            if high < low:
                high += turn
            # Seen edge-on, the segment's ends lie in one direction up to rounding, which alone orders them.
            if high - low > 0.75 * turn:
                low, high = high - turn, low
            nearest, farthest = xs[i] * xs[i] + ys[i] * ys[i], xs[j] * xs[j] + ys[j] * ys[j]
            nearest, farthest = math.sqrt(min(nearest, farthest)), math.sqrt(max(nearest, farthest))
            if high - low < _EDGE_ON_BEAMS:
                cross, farthest = math.inf, nearest
            ex, ey = xs[j] - xs[i], ys[j] - ys[i]
            if high >= turn:  # the same directions one turn earlier
                low -= turn
                high -= turn
            while low < last:
                k = max(math.floor(low) + 1, 0)
                while k <= min(math.floor(high), last):
                    across = cosines[k] * ey - sines[k] * ex
                    r = min(abs(cross) / across, farthest) if across > 0.0 else farthest
                    if r <= range_max and r < ranges[pose, k]:
                        ranges[pose, k] = r
                    k += 1
                low += turn
                high += turn
