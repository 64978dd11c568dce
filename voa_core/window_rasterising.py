"""Ranges of the beams from the chains of contour points, on the beams that can meet the object.

A lidar outside of the object sees it in a window of few beams. The bearing of each point, in float32, chooses the beams
that a segment may cover; which of these it does cover, and where they meet it, is decided in float64, by the sides of
the beam on which its ends lie. The side of a point is computed by one formula for both of its segments, so
neighbouring segments neither both cover a beam nor leave one out.
"""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.chains import Singles
from voa_core.checks import Floats
from voa_core.cutting import Contours
from voa_core.jit import kernel, sum_kernel
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.outlines import Ints
from voa_core.rasterising import EDGE_ON_BEAMS, directions

CLEAR = 1.1
"""A lidar within this many radii of the middle of a cut is too near for bearings in float32."""
MARGIN_RAD = 2e-5
"""Bound of the error of a bearing in float32: tests/voa_core/test_window_rasterising.py measures a tenth of it."""
_SLACK_RAD = 1e-9
_PAIRS = 1024  # of a segment and a beam, decided at once

# atan(t) / t as a polynomial in t^2 for 0 <= t <= 1, by Chebyshev interpolation; the error of the angle is below
# 5e-7 rad. tests/voa_core/test_window_rasterising.py derives the coefficients again.
ATAN_SINGLE = tuple(
    np.float32(coefficient)
    for coefficient in (
        0.9999992251396179,
        -0.3332567811012268,
        0.19872039556503296,
        -0.1344786435365677,
        0.08312645554542542,
        -0.03636043146252632,
        0.007648353930562735,
    )
)
_QUARTER = np.float32(0.5 * math.pi)
_NOTHING, _NEAREST = np.float32(0.0), np.float32(1e-12)


def rasterise_windows(
    contours: Contours, sensor: SensorConfiguration, grid: BeamGrid, range_max: float
) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
    """Compute the ranges that a lidar at `sensor` measures for the poses that it sees from well outside.

    Args:
        contours: the cuts of all poses.
        sensor: where the lidar stands.
        grid: its beams.
        range_max: metres; a hit beyond is a no-return.

    Returns:
        The indices (c,), ascending, of the beams on which a pose returns; the ranges (n, c) on them, metres, inf for a
        no-return; and flags (n,) of the poses that were seen from well outside: the ranges of others are inf.
    """
    mirror = 1.0 if grid.angle_increment > 0.0 else -1.0
    cosines, sines = directions(grid, mirror)
    chains = contours.chains
    return _rasterise(
        chains.x,
        chains.y,
        chains.near_x,
        chains.near_y,
        chains.joined,
        chains.start,
        chains.circles,
        contours.cut_of_pose,
        contours.placement,
        np.array([sensor.x, sensor.y, math.cos(sensor.yaw_rad), math.sin(sensor.yaw_rad), mirror]),
        cosines,
        sines,
        mirror * grid.angle_min,
        abs(grid.angle_increment),
        range_max,
    )


@sum_kernel
def bearing(y: np.float32, x: np.float32) -> np.float32:
    """atan2(y, x) for x > 0 in float32, without branches, so that a loop over points runs in vector registers."""
    ay = abs(y)
    steep = ay > x
    t = (x if steep else ay) / (ay if steep else x)
    u = t * t
    p = ATAN_SINGLE[6]
    p = p * u + ATAN_SINGLE[5]
    p = p * u + ATAN_SINGLE[4]
    p = p * u + ATAN_SINGLE[3]
    p = p * u + ATAN_SINGLE[2]
    p = p * u + ATAN_SINGLE[1]
    p = p * u + ATAN_SINGLE[0]
    a = p * t
    a = _QUARTER - a if steep else a
    return -a if y < _NOTHING else a


@kernel
def _rasterise(
    xs: Floats,
    ys: Floats,
    near_x: Singles,
    near_y: Singles,
    joined: NDArray[np.bool_],
    start: NDArray[np.int64],
    circles: Floats,
    cut_of_pose: NDArray[np.int64],
    placement: Floats,
    sensor: Floats,
    cosines: Floats,
    sines: Floats,
    angle_min: float,
    spacing: float,
    range_max: float,
) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
    turn = 2.0 * math.pi / spacing  # beams in one turn, in general not a whole number
    frames, views = np.zeros((len(cut_of_pose), 6)), np.zeros((len(cut_of_pose), 4))
    for pose in range(len(cut_of_pose)):
        _frame(placement[pose], sensor, frames[pose])
        _view(circles[cut_of_pose[pose]], frames[pose], angle_min, spacing, views[pose])
    windows, columns = _windows(views, turn, len(cosines))
    column_of_beam = np.zeros(len(cosines), dtype=np.int64)
    column_of_beam[columns] = np.arange(len(columns))
    ranges, seen = np.full((len(cut_of_pose), len(columns)), np.inf), np.zeros(len(columns), dtype=np.bool_)
    most = (start[1:] - start[:-1]).max()
    bearings, first, many = np.zeros(most, np.float32), np.zeros(most, np.int32), np.zeros(most, np.int32)
    candidates, pairs, hits = np.zeros(most, np.int32), np.zeros((6, _PAIRS)), np.zeros(_PAIRS)
    met, ahead_frame = np.zeros(_PAIRS, dtype=np.int64), np.zeros(6)
    for pose in range(len(cut_of_pose)):
        begin, end = start[cut_of_pose[pose]], start[cut_of_pose[pose] + 1]
        if begin == end or views[pose, 3] < 0.0:
            continue
        own, frame, row = bearings[: end - begin], frames[pose], ranges[pose]
        _turn_ahead(frame, views[pose], ahead_frame)
        aim(near_x[begin:end], near_y[begin:end], ahead_frame, np.float32(1.0 / spacing), own)
        for lap in range(windows.shape[1]):
            low, high = windows[pose, lap]
            if high < low:
                continue
            ahead = views[pose, 2] + lap * turn - low
            _span(own, joined[begin:end], ahead, MARGIN_RAD / spacing, low, high, first, many)
            count = 0
            for candidate in candidates[: _compress(many[: end - begin - 1], candidates)]:
                i = begin + candidate
                x, y = moved(frame, xs[i], ys[i])
                next_x, next_y = moved(frame, xs[i + 1], ys[i + 1])
                for beam in range(first[candidate], first[candidate] + many[candidate]):
                    pairs[0, count], pairs[1, count], pairs[2, count], pairs[3, count] = x, y, next_x, next_y
                    pairs[4, count], pairs[5, count] = cosines[beam], sines[beam]
                    met[count] = column_of_beam[beam]
                    count += 1
                    if count == _PAIRS:
                        decide(pairs, count, EDGE_ON_BEAMS * spacing, range_max, hits)
                        _enter(met, hits, count, row, seen)
                        count = 0
            decide(pairs, count, EDGE_ON_BEAMS * spacing, range_max, hits)
            _enter(met, hits, count, row, seen)
    return columns[seen], _chosen(ranges, seen), views[:, 3] >= 0.0


@kernel
def _frame(placement: Floats, sensor: Floats, frame: Floats) -> None:
    """Write the motion from the frame of a cut to that of the sensor: two rows of a matrix, and an offset."""
    c, s = placement[0], placement[1]
    tx, ty = placement[2] - sensor[0], placement[3] - sensor[1]
    frame[0], frame[1] = sensor[2] * c + sensor[3] * s, sensor[3] * c - sensor[2] * s
    frame[2], frame[3] = -sensor[4] * frame[1], sensor[4] * frame[0]
    frame[4], frame[5] = sensor[2] * tx + sensor[3] * ty, sensor[4] * (sensor[2] * ty - sensor[3] * tx)


@kernel
def _view(circle: Floats, frame: Floats, angle_min: float, spacing: float, view: Floats) -> None:
    """Write how the sensor sees the circle around a cut.

    Args:
        view: x and y of its middle in the frame of the sensor, the beam coordinate of the middle, and half the angle
            that it covers, in beams; -1 where the sensor is too near for bearings in float32.
    """
    x = frame[0] * circle[0] + frame[1] * circle[1] + frame[4]
    y = frame[2] * circle[0] + frame[3] * circle[1] + frame[5]
    away, radius = math.sqrt(x * x + y * y), circle[2]
    turns = (math.atan2(y, x) - angle_min) / (2.0 * math.pi)
    view[0], view[1] = x, y
    view[2] = (turns - math.floor(turns + 0.5)) * 2.0 * math.pi / spacing
    view[3] = (math.asin(radius / away) + _SLACK_RAD) / spacing if away > CLEAR * radius else -1.0


@kernel
def _windows(views: Floats, turn: float, beams: int) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """Find the beams that can meet a cut: the first and the last, in each turn of the grid; and those of all poses."""
    laps = math.floor((beams - 1) / turn + 0.75) + 1
    windows = np.zeros((len(views), laps, 2), dtype=np.int64)
    met = np.zeros(beams, dtype=np.bool_)
    for pose in range(len(views)):
        for lap in range(laps):
            ahead, half = views[pose, 2] + lap * turn, views[pose, 3]
            low, high = max(math.ceil(ahead - half), 0), min(math.floor(ahead + half), beams - 1)
            windows[pose, lap, 0], windows[pose, lap, 1] = low, high
            for beam in range(low, high + 1):
                met[beam] = True
    return windows, np.flatnonzero(met)


@kernel
def _turn_ahead(frame: Floats, view: Floats, ahead: Floats) -> None:
    """Write the motion from a cut, from its middle, to the frame of the sensor turned towards that middle."""
    away = math.sqrt(view[0] * view[0] + view[1] * view[1])
    c, s = view[0] / away, view[1] / away
    ahead[0], ahead[1] = c * frame[0] + s * frame[2], c * frame[1] + s * frame[3]
    ahead[2], ahead[3] = c * frame[2] - s * frame[0], c * frame[3] - s * frame[1]
    ahead[4], ahead[5] = away, 0.0


@sum_kernel
def aim(xs: Singles, ys: Singles, frame: Floats, beams_per_rad: np.float32, bearings: Singles) -> None:
    """Compute the bearings of points, moved by a frame (6,) to straight ahead of the sensor, in beams."""
    xx, xy, yx, yy = np.float32(frame[0]), np.float32(frame[1]), np.float32(frame[2]), np.float32(frame[3])
    x0, y0 = np.float32(frame[4]), np.float32(frame[5])
    for i in range(len(bearings)):
        x, y = xs[i], ys[i]
        bearings[i] = bearing(yx * x + yy * y + y0, max(xx * x + xy * y + x0, _NEAREST)) * beams_per_rad


@sum_kernel
def _span(
    bearings: Singles,
    joined: NDArray[np.bool_],
    ahead: float,
    margin: float,
    low: int,
    high: int,
    first: Ints,
    many: Ints,
) -> None:
    """Find the beams from `low` to `high` that the segment from each point to the next may cover.

    Args:
        ahead: beam coordinate of the bearing 0, counted from the beam `low`.
        margin: error of a bearing, in beams.
    """
    below, above = np.float32(ahead + 1.0 - margin), np.float32(ahead + 1.0 + margin)
    base, end = np.int32(low), np.int32(high - low + 1)
    for i in range(len(bearings) - 1):
        a, b = bearings[i], bearings[i + 1]
        begin, stop = max(np.int32(min(a, b) + below), np.int32(0)), min(np.int32(max(a, b) + above), end)
        first[i] = begin + base
        many[i] = stop - begin if joined[i] else np.int32(0)


@kernel
def _compress(many: Ints, candidates: Ints) -> int:
    """Write the indices of entries that are above 0; their number is returned."""
    count = 0
    for i in range(len(many)):  # without a branch, which a processor could not predict
        candidates[count] = i
        count += many[i] > 0
    return count


@kernel
def moved(frame: Floats, x: float, y: float) -> tuple[float, float]:
    """A point of a cut in the frame of the sensor: one formula for both segments of a point."""
    return frame[0] * x + frame[1] * y + frame[4], frame[2] * x + frame[3] * y + frame[5]


@kernel
def decide(pairs: Floats, count: int, edge_on: float, range_max: float, hits: Floats) -> None:
    """Compute the ranges at which segments meet beams; inf where they do not.

    Args:
        pairs: (6, _PAIRS) x and y of the first end of each segment, of its second, cosine and sine of the beam.
        count: of pairs.
        edge_on: a segment that spans less, in radians, has its nearer end in front.
        range_max: metres; a hit beyond is a no-return.
        hits: ranges, metres.
    """
    ix, iy, jx, jy, cosines, sines = pairs[0], pairs[1], pairs[2], pairs[3], pairs[4], pairs[5]
    for p in range(count):
        c, s = cosines[p], sines[p]
        # Both ends in the beam's own frame: how far along it, and how far to its left.
        along_i, left_i = c * ix[p] + s * iy[p], c * iy[p] - s * ix[p]
        along_j, left_j = c * jx[p] + s * jy[p], c * jy[p] - s * jx[p]
        nearer = along_i if along_i < along_j else along_j
        apart = left_i - left_j
        r = along_i + left_i / (apart if apart != 0.0 else 1.0) * (along_j - along_i)
        r = nearer if abs(apart) < edge_on * nearer else r
        hits[p] = r if ((left_i < 0.0) != (left_j < 0.0)) & (r <= range_max) else np.inf


@kernel
def _enter(met: NDArray[np.int64], hits: Floats, count: int, row: Floats, seen: NDArray[np.bool_]) -> None:
    """Enter hits into the ranges (c,) of one pose, and flag the columns that have one."""
    for p in range(count):
        column = met[p]
        row[column] = min(row[column], hits[p])
        seen[column] |= hits[p] < np.inf


@kernel
def _chosen(ranges: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Copy the columns that are flagged."""
    columns = np.flatnonzero(seen)
    chosen = np.zeros((len(ranges), len(columns)))
    for row in range(len(ranges)):
        for column in range(len(columns)):
            chosen[row, column] = ranges[row, columns[column]]
    return chosen
