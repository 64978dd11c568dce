"""Outlines of the object in the scan plane, reduced to the edges that a lidar outside of it can see first.

A cut has a point for every edge of the mesh that the plane meets, and contours that others surround. For displaced
copies each point costs as much as for a pose, so the cut is reduced once: points on a straight line are dropped, so are
contours inside another one, and the edges of a contour are ordered such that those that face away can be recognised.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel

_STRAIGHT_M = 1e-13
_APART_M = 1e-11  # contours that come nearer to each other than this are treated as if they met

Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of the cuts of one plane.

    Every hit that is the nearest along a ray from outside lies on an edge that faces the lidar: its interior is to the
    left, so the lidar is to the right of it. An edge of which the interior is unknown is listed in both directions.

    Attributes:
        points: (q, 2) metres, each cut in its own planar frame.
        edges: (g, 2) indices of points within their cut, from and to.
        point_start, edge_start: (cuts + 1,) offsets of each cut into `points` and `edges`.
        reach: (cuts,) largest distance of a point from the origin of the frame, metres.
    """

    points: Floats
    edges: Ints
    point_start: NDArray[np.int64]
    edge_start: NDArray[np.int64]
    reach: Floats

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.points.nbytes + self.edges.nbytes


def outlines_of(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> Outlines:
    """Reduce cuts, as `cutting.Contours` has them, to outlines."""
    return Outlines(*_outlines(points, segments, point_start, segment_start))


@kernel
def _outlines(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> tuple[Floats, Ints, NDArray[np.int64], NDArray[np.int64], Floats]:
    cuts = len(point_start) - 1
    kept, edges = np.zeros((len(points), 2)), np.zeros((2 * len(segments), 2), dtype=np.int32)
    points_kept, edges_kept = np.zeros(cuts + 1, dtype=np.int64), np.zeros(cuts + 1, dtype=np.int64)
    reach = np.zeros(cuts)
    for cut in range(cuts):
        own = points[point_start[cut] : point_start[cut + 1]]
        joined = segments[segment_start[cut] : segment_start[cut + 1]]
        p, e = points_kept[cut], edges_kept[cut]
        corners, loop_start = _corners(own, joined)
        if len(corners) == 0 and len(joined) > 0:  # an open mesh: nothing is known of the inside
            kept[p : p + len(own)] = own
            for g in range(len(joined)):
                edges[e, 0], edges[e, 1] = joined[g, 0], joined[g, 1]
                edges[e + 1, 0], edges[e + 1, 1] = joined[g, 1], joined[g, 0]
                e += 2
            p += len(own)
        else:
            outline = own[corners]
            kept[p : p + len(outline)] = outline
            e += _edges_of_loops(outline, loop_start, edges[e:])
            p += len(outline)
        for point in range(points_kept[cut], p):
            reach[cut] = max(reach[cut], math.hypot(kept[point, 0], kept[point, 1]))
        points_kept[cut + 1], edges_kept[cut + 1] = p, e
    return kept[: points_kept[-1]].copy(), edges[: edges_kept[-1]].copy(), points_kept, edges_kept, reach


@kernel
def _corners(points: Floats, segments: Ints) -> tuple[Ints, NDArray[np.int64]]:
    """Indices of the corners of all contours, contour by contour, and where each contour starts, with the end.

    There are none where a point does not belong to exactly two segments.
    """
    neighbours, at_most_two = neighbours_of(segments, len(points))
    if not at_most_two or (neighbours < 0).any():
        return np.zeros(0, dtype=np.int32), np.zeros(1, dtype=np.int64)
    left = np.ones(len(points), dtype=np.bool_)  # points whose contour is still to be followed
    corners, count = np.zeros(len(points), dtype=np.int32), 0
    starts, loops = np.zeros(len(points) + 1, dtype=np.int64), 0
    loop = np.zeros(len(points), dtype=np.int32)
    for first in range(len(points)):
        if not left[first]:
            continue
        length, point = 0, np.int32(first)
        while left[point]:
            left[point] = False
            loop[length] = point
            length += 1
            point = neighbours[point, 0] if left[neighbours[point, 0]] else neighbours[point, 1]
        last = loop[0]
        corners[count] = last
        count += 1
        for index in range(1, length):
            if not is_straight(points[last], points[loop[index]], points[loop[(index + 1) % length]]):
                last = loop[index]
                corners[count] = last
                count += 1
        loops += 1
        starts[loops] = count
    return corners[:count].copy(), starts[: loops + 1].copy()


@kernel
def neighbours_of(segments: Ints, points: int) -> tuple[Ints, bool]:
    """Find the points (points, 2) to which segments (g, 2) lead from each, -1 for none; False if some have more."""
    neighbours = np.full((points, 2), -1, dtype=np.int32)
    for g in range(len(segments)):
        for end in range(2):
            point, other = segments[g, end], segments[g, 1 - end]
            if neighbours[point, 0] < 0:
                neighbours[point, 0] = other
            elif neighbours[point, 1] < 0:
                neighbours[point, 1] = other
            else:
                return neighbours, False
    return neighbours, True


@kernel
def is_straight(a: Floats, b: Floats, c: Floats) -> bool:
    """True if b lies on the segment from a to c, to rounding."""
    dx, dy = c[0] - a[0], c[1] - a[1]
    ex, ey = b[0] - a[0], b[1] - a[1]
    along = ex * dx + ey * dy
    square = dx * dx + dy * dy
    return bool(0.0 < along < square and (dx * ey - dy * ex) ** 2 <= _STRAIGHT_M * _STRAIGHT_M * square)


@kernel
def _edges_of_loops(outline: Floats, start: NDArray[np.int64], edges: Ints) -> int:
    """Write the edges of the contours that may be seen, with the interior to the left; their number is returned."""
    loops = len(start) - 1
    folded, meets = _crossings(outline, start)
    count = 0
    for loop in range(loops):
        first, last = start[loop], start[loop + 1]
        if not meets[loop] and not folded[loop] and _is_surrounded(outline, start, loop):
            continue
        area = 0.0
        for i in range(first, last):
            j = i + 1 if i + 1 < last else first
            area += outline[i, 0] * outline[j, 1] - outline[j, 0] * outline[i, 1]
        for i in range(first, last):
            j = i + 1 if i + 1 < last else first
            if area >= 0.0 or folded[loop]:
                edges[count, 0], edges[count, 1] = i, j
                count += 1
            if area <= 0.0 or folded[loop]:
                edges[count, 0], edges[count, 1] = j, i
                count += 1
    return count


@kernel
def _is_surrounded(outline: Floats, start: NDArray[np.int64], loop: int) -> bool:
    """True if a contour that meets no other one lies inside another: each ray from outside meets that one first."""
    x, y = outline[start[loop], 0], outline[start[loop], 1]
    for other in range(len(start) - 1):
        if other == loop:
            continue
        inside = False
        first, last = start[other], start[other + 1]
        for i in range(first, last):
            j = i + 1 if i + 1 < last else first
            if (outline[i, 1] > y) != (outline[j, 1] > y):
                share = (y - outline[i, 1]) / (outline[j, 1] - outline[i, 1])
                if x < outline[i, 0] + share * (outline[j, 0] - outline[i, 0]):
                    inside = not inside
        if inside:
            return True
    return False


@kernel
def _crossings(outline: Floats, start: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Flags of the contours that meet themselves, and of those that meet another, by a sweep along x."""
    loops, n = len(start) - 1, len(outline)
    folded, meets = np.zeros(loops, dtype=np.bool_), np.zeros(loops, dtype=np.bool_)
    loop_of, end = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    left, right = np.zeros(n), np.zeros(n)
    for loop in range(loops):
        folded[loop] = start[loop + 1] - start[loop] < 3
        for i in range(start[loop], start[loop + 1]):
            loop_of[i] = loop
            end[i] = i + 1 if i + 1 < start[loop + 1] else start[loop]
            left[i] = min(outline[i, 0], outline[end[i], 0])
            right[i] = max(outline[i, 0], outline[end[i], 0]) + _APART_M
    order = np.argsort(left)
    for at in range(n):
        i = order[at]
        for other in range(at + 1, n):
            k = order[other]
            if left[k] > right[i]:
                break
            if end[i] == k:
                folded[loop_of[i]] |= _folds(outline[i], outline[k], outline[end[k]])
            elif end[k] == i:
                folded[loop_of[i]] |= _folds(outline[k], outline[i], outline[end[i]])
            elif _meet(outline[i], outline[end[i]], outline[k], outline[end[k]]):
                same = loop_of[i] == loop_of[k]
                folded[loop_of[i]] |= same
                meets[loop_of[i]] |= not same
                meets[loop_of[k]] |= not same
    return folded, meets


@kernel
def _folds(a: Floats, b: Floats, c: Floats) -> bool:
    """True if the edge from b to c leads back along the edge from a to b."""
    ax, ay, cx, cy = a[0] - b[0], a[1] - b[1], c[0] - b[0], c[1] - b[1]
    longer = max(math.hypot(ax, ay), math.hypot(cx, cy))
    return bool(ax * cx + ay * cy > 0.0 and abs(ax * cy - ay * cx) <= _APART_M * longer)


@kernel
def _meet(a: Floats, b: Floats, c: Floats, d: Floats) -> bool:
    """True unless the segments ab and cd are clearly apart: both ends of one lie on one side of the other."""
    return not (_on_one_side(a, b, c, d) or _on_one_side(c, d, a, b))


@kernel
def _on_one_side(a: Floats, b: Floats, c: Floats, d: Floats) -> bool:
    x, y = b[0] - a[0], b[1] - a[1]
    limit = _APART_M * math.hypot(x, y)
    of_c = x * (c[1] - a[1]) - y * (c[0] - a[0])
    of_d = x * (d[1] - a[1]) - y * (d[0] - a[0])
    return bool((of_c > limit and of_d > limit) or (of_c < -limit and of_d < -limit))
