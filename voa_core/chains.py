"""Chains of contour points: the cuts of the object in an order in which most segments join a point to the next one.

A loop over segments then reads each point once, in order, which vector registers do well. Points on a straight line
between their neighbours are dropped.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel
from voa_core.outlines import Ints, is_straight, neighbours_of

Singles = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Chains:
    """Chains of the cuts of one plane, and a circle around each cut.

    Attributes:
        x, y: (q,) of every point, metres, each cut in its own planar frame. A closed chain ends with its first point
            again.
        near_x, near_y: (q,) float32, the same from the middle of the circle of the cut.
        joined: (q,) True where a segment leads from a point to the next one.
        start: (cuts + 1,) offsets of each cut into the points.
        circles: (cuts, 3) x, y and radius of a circle that holds every point of a cut, metres.
    """

    x: Floats
    y: Floats
    near_x: Singles
    near_y: Singles
    joined: NDArray[np.bool_]
    start: NDArray[np.int64]
    circles: Floats

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return sum(part.nbytes for part in (self.x, self.y, self.near_x, self.near_y, self.joined))


def chains_of(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> Chains:
    """Order cuts, as `cutting.Contours` has them, into chains."""
    return Chains(*_chains(points, segments, point_start, segment_start))


@kernel
def _chains(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> tuple[Floats, Floats, Singles, Singles, NDArray[np.bool_], NDArray[np.int64], Floats]:
    cuts = len(point_start) - 1
    # The points of all chains in order, as indices into those of their cut; no chain is shorter than one segment.
    order, joined = np.zeros(2 * len(segments), dtype=np.int32), np.zeros(2 * len(segments), dtype=np.bool_)
    start = np.zeros(cuts + 1, dtype=np.int64)
    for cut in range(cuts):
        own = points[point_start[cut] : point_start[cut + 1]]
        pairs = segments[segment_start[cut] : segment_start[cut + 1]]
        first = start[cut]
        neighbours, at_most_two = neighbours_of(pairs, len(own))
        if at_most_two:
            start[cut + 1] = first + _follow(own, neighbours, order[first:], joined[first:])
        else:
            start[cut + 1] = first + _separate(pairs, order[first:], joined[first:])
    end = start[cuts]
    x, y = np.zeros(end), np.zeros(end)
    near_x, near_y = np.zeros(end, dtype=np.float32), np.zeros(end, dtype=np.float32)
    circles = np.zeros((cuts, 3))
    for cut in range(cuts):
        first, last = start[cut], start[cut + 1]
        for at in range(first, last):
            point = point_start[cut] + order[at]
            x[at], y[at] = points[point, 0], points[point, 1]
        if last > first:
            _surround(x[first:last], y[first:last], near_x[first:last], near_y[first:last], circles[cut])
    return x, y, near_x, near_y, joined[:end].copy(), start, circles


@kernel
def _follow(points: Floats, neighbours: Ints, order: Ints, joined: NDArray[np.bool_]) -> int:
    """Write the chains of points of which none has more than two neighbours; the number of entries is returned."""
    left = np.ones(len(points), dtype=np.bool_)  # points whose chain is still to be followed
    count = 0
    for open_ends in (True, False):  # a chain with ends begins at one of them
        for begin in range(len(points)):
            if not left[begin] or neighbours[begin, 0] < 0 or (open_ends and neighbours[begin, 1] >= 0):
                continue
            point, before, first = np.int32(begin), np.int32(-1), count
            while point >= 0:
                if count - first >= 2 and is_straight(points[order[count - 2]], points[before], points[point]):
                    count -= 1
                order[count], joined[count] = point, True
                count += 1
                if not left[point]:  # closed
                    break
                left[point] = False
                after = neighbours[point, 0] if neighbours[point, 0] != before else neighbours[point, 1]
                point, before = after, point
            joined[count - 1] = False
    return count


@kernel
def _separate(segments: Ints, order: Ints, joined: NDArray[np.bool_]) -> int:
    """Write each segment as a chain of its own; the number of entries is returned."""
    for g in range(len(segments)):
        order[2 * g], order[2 * g + 1] = segments[g, 0], segments[g, 1]
        joined[2 * g], joined[2 * g + 1] = True, False
    return 2 * len(segments)


@kernel
def _surround(x: Floats, y: Floats, near_x: Singles, near_y: Singles, circle: Floats) -> None:
    """Write the circle around points, and the points from its middle."""
    circle[0], circle[1] = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
    square = 0.0
    for point in range(len(x)):
        dx, dy = x[point] - circle[0], y[point] - circle[1]
        square = max(square, dx * dx + dy * dy)
        near_x[point], near_y[point] = dx, dy
    circle[2] = math.sqrt(square)
