"""Ranges of the beams from the outlines of many displaced copies of an object, on the beams that can meet it.

As in `rasterising`, every point gets one beam coordinate, shared by the edges that meet there, and an edge covers the
beams of the half-open interval between its ends. The lidar is turned towards the object, so that no interval leads
through the back; edges that face away are passed over.
"""

import math

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel, sum_kernel
from voa_core.outlines import Ints
from voa_core.rasterising import ATAN, EDGE_ON_BEAMS, angle

_NARROW_RAD = math.pi / 8.0


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
    copies, last_beam, turn = ranges.shape[1], len(cosines) - 1, 2.0 * math.pi / spacing
    most = 0
    for cut in range(len(point_start) - 1):
        most = max(most, point_start[cut + 1] - point_start[cut], edge_start[cut + 1] - edge_start[cut])
    px, py, xs = np.zeros(most), np.zeros(most), np.zeros(most)
    ys, us, vs = np.zeros(most), np.zeros(most), np.zeros(most)
    cells, where = np.zeros(most, dtype=np.int32), np.full(most, -1, dtype=np.int32)
    ends, candidates = np.zeros((most, 2), dtype=np.int32), np.zeros(most, dtype=np.int32)
    seen_x, seen_y = np.zeros(copies), np.zeros(copies)
    turned = np.zeros((2, len(cosines)))  # directions of the beams in the turned frame
    mirror = sensor[4]
    row = 0
    for pose in range(len(cut_of_pose)):
        start[pose] = row
        if not clear[pose]:
            continue
        c, s, tx, ty = placement[pose, 0], placement[pose, 1], placement[pose, 2], placement[pose, 3]
        dx, dy, dc, ds = displacements[0, pose], displacements[1, pose], displacements[2, pose], displacements[3, pose]
        for j in range(copies):  # the sensor in the frame of the cut
            cj, sj = c * dc[j] - s * ds[j], s * dc[j] + c * ds[j]
            ax, ay = sensor[0] - tx - dx[j], sensor[1] - ty - dy[j]
            seen_x[j], seen_y[j] = cj * ax + sj * ay, cj * ay - sj * ax
        cut = cut_of_pose[pose]
        outline = points[point_start[cut] : point_start[cut + 1]]
        n, g = _facing(
            outline, edges[edge_start[cut] : edge_start[cut + 1]], seen_x, seen_y, mirror, where, px, py, ends
        )
        # The frame of the sensor, turned such that the pose lies straight ahead.
        ax, ay = tx - sensor[0], ty - sensor[1]
        ahead_x, ahead_y = sensor[2] * ax + sensor[3] * ay, mirror * (sensor[2] * ay - sensor[3] * ax)
        away = math.hypot(ahead_x, ahead_y)
        cb, sb = ahead_x / away, ahead_y / away
        bearing = math.atan2(ahead_y, ahead_x)
        first_row = row
        for lap in range(-2, 3):
            ahead = (bearing - angle_min + 2.0 * math.pi * lap) / spacing
            low = max(math.floor(ahead - half[pose] / spacing), 0)
            high = min(math.ceil(ahead + half[pose] / spacing), last_beam)
            window = ranges[row : row + max(high + 1 - low, 0)]
            _open(window, low, cosines, sines, cb, sb, beams[row:], turned)
            if high < low:
                continue
            shift = math.floor(turn) + 2 + max(0, -math.floor(ahead))
            for j in range(copies):
                cj, sj = c * dc[j] - s * ds[j], s * dc[j] + c * ds[j]
                # From the cut to the world, to the sensor, mirrored, and turned.
                wx, wy = sensor[2] * cj + sensor[3] * sj, sensor[2] * sj - sensor[3] * cj
                ox, oy = tx + dx[j] - sensor[0], ty + dy[j] - sensor[1]
                ox, oy = sensor[2] * ox + sensor[3] * oy, mirror * (sensor[2] * oy - sensor[3] * ox)
                _place(
                    px[:n],
                    py[:n],
                    cb * wx + sb * mirror * wy,
                    sb * mirror * wx - cb * wy,
                    cb * mirror * wy - sb * wx,
                    cb * mirror * wx + sb * wy,
                    cb * ox + sb * oy,
                    cb * oy - sb * ox,
                    xs[:n],
                    ys[:n],
                )
                if half[pose] < _NARROW_RAD:
                    _aim_ahead(xs[:n], ys[:n], 1.0 / spacing, ahead + shift, vs[:n], cells[:n])
                else:
                    _aim(xs[:n], ys[:n], 1.0 / spacing, ahead + shift, us[:n], vs[:n], cells[:n])
                _cover(ends[:g], xs, ys, vs, cells, candidates, turned, low + shift, range_max, window, j)
            row += high + 1 - low
        row = _without_empty(first_row, row, beams, ranges)
    start[len(cut_of_pose)] = row


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
    ends: Ints,
    xs: Floats,
    ys: Floats,
    vs: Floats,
    cells: Ints,
    candidates: Ints,
    turned: Floats,
    low: int,
    range_max: float,
    window: Floats,
    copy: int,
) -> None:
    """Enter the edges (g, 2) that face the lidar into the ranges (w, J) of one copy; `low` is the first beam's cell."""
    count = 0
    for e in range(len(ends)):  # without a branch, which a processor could not predict
        candidates[count] = e
        count += cells[ends[e, 0]] < cells[ends[e, 1]]
    for e in candidates[:count]:
        i, k = ends[e, 0], ends[e, 1]
        for cell in range(max(cells[i] + 1, low), min(cells[k], low + len(window) - 1) + 1):
            at = cell - low
            cr, sr = turned[0, at], turned[1, at]
            # Both ends in the beam's own frame: how far along it, and how far to its left.
            along_i, left_i = cr * xs[i] + sr * ys[i], cr * ys[i] - sr * xs[i]
            along_k, left_k = cr * xs[k] + sr * ys[k], cr * ys[k] - sr * xs[k]
            share = left_i / (left_i - left_k) if left_i < min(left_k, 0.0) else 0.0
            r = max(along_i + min(share, 1.0) * (along_k - along_i), 0.0)
            if vs[k] - vs[i] < EDGE_ON_BEAMS:
                r = min(along_i, along_k)
            window[at, copy] = min(window[at, copy], r if r <= range_max else math.inf)


@kernel
def _facing(
    outline: Floats,
    edges: Ints,
    seen_x: Floats,
    seen_y: Floats,
    mirror: float,
    where: Ints,
    px: Floats,
    py: Floats,
    ends: Ints,
) -> tuple[int, int]:
    """Select the edges that face the lidar in any copy, and their points; the numbers of both are returned.

    The bearing of a selected edge rises from its first to its second end in `ends`, where it faces the lidar.
    """
    n, g = 0, 0
    for e in range(len(edges)):
        a, b = edges[e, 0], edges[e, 1]
        x, y = outline[a, 0], outline[a, 1]
        ux, uy = outline[b, 0] - x, outline[b, 1] - y
        least = np.inf  # smallest distance to the left of the edge, times its length, over the copies
        for j in range(len(seen_x)):
            least = min(least, ux * (seen_y[j] - y) - uy * (seen_x[j] - x))
        if least > 0.0:
            continue
        for point in (a, b):
            if where[point] < 0:
                where[point] = n
                px[n], py[n] = outline[point, 0], outline[point, 1]
                n += 1
        ends[g, 0], ends[g, 1] = (where[b], where[a]) if mirror > 0.0 else (where[a], where[b])
        g += 1
    where[: len(outline)] = -1
    return n, g


@sum_kernel
def _place(
    px: Floats, py: Floats, xx: float, xy: float, yx: float, yy: float, x0: float, y0: float, xs: Floats, ys: Floats
) -> None:
    """Transform points to the turned frame of the sensor."""
    for i in range(len(px)):
        xs[i] = xx * px[i] + xy * py[i] + x0
        ys[i] = yx * px[i] + yy * py[i] + y0


@sum_kernel
def _aim(xs: Floats, ys: Floats, beams_per_rad: float, ahead: float, us: Floats, vs: Floats, cells: Ints) -> None:
    """Compute the beam coordinate of each point, which is positive, and the beam before it."""
    for i in range(len(us)):  # two loops: one for both would not run in vector registers
        us[i] = angle(ys[i], xs[i])
    for i in range(len(us)):
        vs[i] = us[i] * beams_per_rad + ahead
        cells[i] = np.int32(vs[i])


@sum_kernel
def _aim_ahead(xs: Floats, ys: Floats, beams_per_rad: float, ahead: float, vs: Floats, cells: Ints) -> None:
    """Compute what `_aim` does for points that lie within 22.5 degrees of straight ahead."""
    for i in range(len(vs)):
        vs[i] = ys[i] / xs[i]
    for i in range(len(vs)):
        t = vs[i]
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
        vs[i] = p * t * beams_per_rad + ahead
        cells[i] = np.int32(vs[i])


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
