"""Ranges of the beams from the outlines of many displaced copies of an object, on the beams that can meet it.

As in `window_rasterising`, the bearing of each point, in float32, chooses the beams that an edge may cover, and the
sides of the beam on which its ends lie decide in float64. The lidar is turned towards the object, so that no edge leads
through the back; edges that face away are passed over.
"""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.chains import Singles
from voa_core.checks import Floats
from voa_core.jit import kernel
from voa_core.outlines import Ints
from voa_core.rasterising import EDGE_ON_BEAMS
from voa_core.window_rasterising import MARGIN_RAD, aim, decide, moved

_PAIRS = 256  # of an edge and a beam, decided at once
_SLACK_M = 1e-9


@kernel
def rasterise_copies(
    points: Floats,
    edges: Ints,
    point_start: NDArray[np.int64],
    edge_start: NDArray[np.int64],
    cut_of_pose: NDArray[np.int64],
    placement: Floats,
    displacements: Floats,
    clear: NDArray[np.bool_],
    half: Floats,
    sensor: Floats,
    cosines: Floats,
    sines: Floats,
    angle_min: float,
    spacing: float,
    range_max: float,
    start: NDArray[np.int64],
    beams: Ints,
    ranges: Floats,
) -> None:
    """Write `start`, `beams` and `ranges` of DisplacedScans for the poses that are `clear`.

    Args:
        displacements: (4, k, J) x, y, and cosine and sine of the yaw.
        half: (k,) half the angle, as the lidar sees it, that holds all copies of a pose.
        sensor: x, y, cosine and sine of the yaw, and -1 for a lidar that turns clockwise, else 1.
    """
    last_beam, most = len(cosines) - 1, 0
    for cut in range(len(point_start) - 1):
        most = max(most, point_start[cut + 1] - point_start[cut], edge_start[cut + 1] - edge_start[cut])
    xs, ys, where = np.zeros(most), np.zeros(most), np.full(most, -1, dtype=np.int32)
    ends, frames = np.zeros((2, most), dtype=np.int32), np.zeros((ranges.shape[1], 6))
    turned = np.zeros((2, len(cosines)))  # directions of the beams in the turned frame
    row = 0
    for pose in range(len(cut_of_pose)):
        start[pose] = row
        if not clear[pose]:
            continue
        # The frame of the sensor, turned such that the pose lies straight ahead.
        ax, ay = placement[pose, 2] - sensor[0], placement[pose, 3] - sensor[1]
        ahead_x, ahead_y = sensor[2] * ax + sensor[3] * ay, sensor[4] * (sensor[2] * ay - sensor[3] * ax)
        away = math.hypot(ahead_x, ahead_y)
        cb, sb = ahead_x / away, ahead_y / away
        bearing = math.atan2(ahead_y, ahead_x)
        margin = 0.1 * MARGIN_RAD * (1.0 + 1.0 / max(1.0 - math.sin(half[pose]), 1e-9)) / spacing
        _turn_ahead(placement[pose], displacements[:, pose], sensor, cb, sb, frames)
        cut = cut_of_pose[pose]
        n, g = _facing(
            points[point_start[cut] : point_start[cut + 1]],
            edges[edge_start[cut] : edge_start[cut + 1]],
            frames,
            sensor[4],
            where,
            xs,
            ys,
            ends,
        )
        first_row = row
        for lap in range(-2, 3):
            ahead = (bearing - angle_min + 2.0 * math.pi * lap) / spacing
            low = max(math.floor(ahead - half[pose] / spacing), 0)
            high = min(math.ceil(ahead + half[pose] / spacing), last_beam)
            window = ranges[row : row + max(high + 1 - low, 0)]
            _open(window, low, cosines, sines, cb, sb, beams[row:], turned)
            if high >= low:
                _cover(xs[:n], ys[:n], ends[:, :g], frames, turned, ahead - low, margin, spacing, range_max, window)
                row += high + 1 - low
        row = _without_empty(first_row, row, beams, ranges)
    start[len(cut_of_pose)] = row


@kernel
def _turn_ahead(placement: Floats, displacement: Floats, sensor: Floats, cb: float, sb: float, frames: Floats) -> None:
    """Write the motion (J, 6) of each copy from its cut to the turned frame of the sensor: a matrix and an offset.

    Args:
        displacement: (4, J) x, y, and cosine and sine of the yaw.
        cb, sb: cosine and sine of the bearing of the pose.
    """
    c, s, mirror = placement[0], placement[1], sensor[4]
    for j in range(len(frames)):
        cj = c * displacement[2, j] - s * displacement[3, j]
        sj = s * displacement[2, j] + c * displacement[3, j]
        # From the cut to the world, to the sensor, mirrored, and turned.
        wx, wy = sensor[2] * cj + sensor[3] * sj, sensor[2] * sj - sensor[3] * cj
        ax, ay = placement[2] + displacement[0, j] - sensor[0], placement[3] + displacement[1, j] - sensor[1]
        ox, oy = sensor[2] * ax + sensor[3] * ay, mirror * (sensor[2] * ay - sensor[3] * ax)
        frames[j, 0], frames[j, 1] = cb * wx + sb * mirror * wy, sb * mirror * wx - cb * wy
        frames[j, 2], frames[j, 3] = cb * mirror * wy - sb * wx, cb * mirror * wx + sb * wy
        frames[j, 4], frames[j, 5] = cb * ox + sb * oy, cb * oy - sb * ox


@kernel
def _open(
    window: Floats, low: int, cosines: Floats, sines: Floats, cb: float, sb: float, beams: Ints, turned: Floats
) -> None:
    """Begin the ranges (w, J) of the beams from `low` on, and write their directions in the turned frame."""
    for index in range(len(window)):
        beam = low + index
        beams[index] = beam
        window[index] = np.inf
        turned[0, index] = cosines[beam] * cb + sines[beam] * sb
        turned[1, index] = sines[beam] * cb - cosines[beam] * sb


@kernel
def _cover(
    xs: Floats,
    ys: Floats,
    ends: Ints,
    frames: Floats,
    turned: Floats,
    ahead: float,
    margin: float,
    spacing: float,
    range_max: float,
    window: Floats,
) -> None:
    """Enter the edges (2, g) between points (n,) into the ranges (w, J) of the copies.

    Args:
        frames: (J, 6), as `_turn_ahead` writes them.
        turned: directions of the beams of the window.
        ahead: coordinate of the bearing 0 in the window.
        margin: error of a bearing, in beams.
    """
    near_x, near_y, bearings = xs.astype(np.float32), ys.astype(np.float32), np.zeros(len(xs), dtype=np.float32)
    edges = ends.shape[1]
    first, many = np.zeros(edges, dtype=np.int32), np.zeros(edges, dtype=np.int32)
    candidates = np.zeros(edges, dtype=np.int32)
    pairs, met, hits = np.zeros((6, _PAIRS)), np.zeros(_PAIRS, dtype=np.int64), np.zeros(_PAIRS)
    entries, count = window.reshape(-1), 0
    for j in range(len(frames)):
        aim(near_x, near_y, frames[j], np.float32(1.0 / spacing), bearings)
        chosen = _choose(ends, bearings, ahead, margin, len(window), first, many, candidates)
        for e in candidates[:chosen]:
            x, y = moved(frames[j], xs[ends[0, e]], ys[ends[0, e]])
            next_x, next_y = moved(frames[j], xs[ends[1, e]], ys[ends[1, e]])
            for at in range(first[e], first[e] + many[e]):
                pairs[0, count], pairs[1, count], pairs[2, count], pairs[3, count] = x, y, next_x, next_y
                pairs[4, count], pairs[5, count] = turned[0, at], turned[1, at]
                met[count] = at * len(frames) + j
                count += 1
                if count == _PAIRS:
                    decide(pairs, count, EDGE_ON_BEAMS * spacing, range_max, hits)
                    _enter(met, hits, count, entries)
                    count = 0
    decide(pairs, count, EDGE_ON_BEAMS * spacing, range_max, hits)
    _enter(met, hits, count, entries)


@kernel
def _choose(
    ends: Ints,
    bearings: Singles,
    ahead: float,
    margin: float,
    beams: int,
    first: Ints,
    many: Ints,
    candidates: Ints,
) -> int:
    """Choose the edges that may cover beams of the window; their number is returned.

    Args:
        ends: (2, g) points of the edges.
        bearings: of points, in beams.
        ahead: coordinate of the bearing 0 in the window.
        margin: error of a bearing, in beams.
        beams: number of beams in the window.
        first, many: beams that each edge may cover.
        candidates: the edges with at least one of them.
    """
    below, above = np.float32(ahead + 1.0 - margin), np.float32(ahead + 1.0 + margin)
    count = 0
    for e in range(ends.shape[1]):  # without a branch, which a processor could not predict
        begin = max(np.int32(bearings[ends[0, e]] + below), np.int32(0))
        end = min(np.int32(bearings[ends[1, e]] + above), np.int32(beams))
        first[e], many[e] = begin, end - begin
        candidates[count] = e
        count += int(end > begin)
    return count


@kernel
def _enter(met: NDArray[np.int64], hits: Floats, count: int, entries: Floats) -> None:
    """Enter hits into the ranges (w * J,) of the window."""
    for p in range(count):
        entries[met[p]] = min(entries[met[p]], hits[p])


@kernel
def _facing(
    outline: Floats,
    edges: Ints,
    frames: Floats,
    mirror: float,
    where: Ints,
    xs: Floats,
    ys: Floats,
    ends: Ints,
) -> tuple[int, int]:
    """Select the edges that may face the lidar in some copy, and their points; the numbers of both are returned.

    The bearing of a selected edge rises from its first to its second end in `ends`, where it faces the lidar.

    Args:
        frames: (J, 6), as `_turn_ahead` writes them. In the frame of the cut, a disc holds the lidars of all copies.
    """
    seen_x = -(frames[:, 0] * frames[:, 4] + frames[:, 2] * frames[:, 5])
    seen_y = -(frames[:, 1] * frames[:, 4] + frames[:, 3] * frames[:, 5])
    middle_x, middle_y = 0.5 * (seen_x.min() + seen_x.max()), 0.5 * (seen_y.min() + seen_y.max())
    square = 0.0
    for j in range(len(seen_x)):
        square = max(square, (seen_x[j] - middle_x) ** 2 + (seen_y[j] - middle_y) ** 2)
    radius = math.sqrt(square) + _SLACK_M
    n, g = 0, 0
    for e in range(len(edges)):
        a, b = edges[e, 0], edges[e, 1]
        x, y = outline[a, 0], outline[a, 1]
        ux, uy = outline[b, 0] - x, outline[b, 1] - y
        left = ux * (middle_y - y) - uy * (middle_x - x)  # distance to the left of the edge, times its length
        if left > radius * math.sqrt(ux * ux + uy * uy):
            continue
        for point in (a, b):
            if where[point] < 0:
                where[point] = n
                xs[n], ys[n] = outline[point, 0], outline[point, 1]
                n += 1
        ends[0, g], ends[1, g] = (where[b], where[a]) if mirror > 0.0 else (where[a], where[b])
        g += 1
    where[: len(outline)] = -1
    return n, g


@kernel
def _without_empty(first: int, last: int, beams: Ints, ranges: Floats) -> int:
    """Drop the rows from `first` to before `last` in which no copy returns; the end of those that stay is returned."""
    kept = first
    for row in range(first, last):
        nearest = np.inf
        for j in range(ranges.shape[1]):
            nearest = min(nearest, ranges[row, j])
        if nearest < np.inf:
            if kept < row:
                beams[kept] = beams[row]
                ranges[kept] = ranges[row]
            kept += 1
    return kept
