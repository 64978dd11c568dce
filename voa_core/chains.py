"""Chains of contour points: the cuts of the object in an order in which most segments join a point to the next one.

A loop over segments then reads each point once, in order, which vector registers do well. Points on a straight line
between their neighbours are dropped.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel
from voa_core.outlines import Ints, is_straight, neighbours_of


@dataclass(frozen=True, eq=False)
class Chains:
    """Chains of the cuts of one plane, and a circle around each cut.

    Attributes:
        places: (2, q) float64, x and y of every point, metres, each cut in its own planar frame. A closed chain ends
            with its first point again.
        near: (2, q) float32, the same from the middle of the circle of the cut.
        joined: (q,) True where a segment leads from a point to the next one.
        start: (cuts + 1,) offsets of each cut into the points.
        circles: (cuts, 3) x, y and radius of a circle that holds every point of a cut, metres.
    """

    places: Floats
    near: NDArray[np.float32]
    joined: NDArray[np.bool_]
    start: NDArray[np.int64]
    circles: Floats

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.places.nbytes + self.near.nbytes + self.joined.nbytes


def chains_of(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> Chains:
    """Order cuts, as `cutting.Contours` has them, into chains."""
    return Chains(*_chains(points, segments, point_start, segment_start))


@kernel
def _chains(
    points: Floats, segments: Ints, point_start: NDArray[np.int64], segment_start: NDArray[np.int64]
) -> tuple[Floats, NDArray[np.float32], NDArray[np.bool_], NDArray[np.int64], Floats]:
    cuts = len(point_start) - 1
    most = 2 * len(segments)
    places, near = np.zeros((2, most)), np.zeros((2, most), dtype=np.float32)
    joined = np.zeros(most, dtype=np.bool_)
    start, circles = np.zeros(cuts + 1, dtype=np.int64), np.zeros((cuts, 3))
    for cut in range(cuts):
        own = points[point_start[cut] : point_start[cut + 1]]
        pairs = segments[segment_start[cut] : segment_start[cut + 1]]
        first = start[cut]
        neighbours, at_most_two = neighbours_of(pairs, len(own))
        if at_most_two:
            last = first + _follow(own, neighbours, places[:, first:], joined[first:])
        else:
            last = first + _separate(own, pairs, places[:, first:], joined[first:])
        start[cut + 1] = last
        if last > first:
            _surround(places[:, first:last], near[:, first:last], circles[cut])
    end = start[cuts]
    return places[:, :end].copy(), near[:, :end].copy(), joined[:end].copy(), start, circles


@kernel
def _follow(points: Floats, neighbours: Ints, places: Floats, joined: NDArray[np.bool_]) -> int:
    """Write the chains of points of which none has more than two neighbours; the number of points is returned."""
    left = np.ones(len(points), dtype=np.bool_)  # points whose chain is still to be followed
    count = 0
    for open_ends in (True, False):  # a chain with ends begins at one of them
        for begin in range(len(points)):
            if not left[begin] or neighbours[begin, 0] < 0 or (open_ends and neighbours[begin, 1] >= 0):
                continue
            point, before = begin, -1
            corners = count  # no chain is shorter than one segment
            while point >= 0:
                x, y = points[point, 0], points[point, 1]
                if count - corners >= 2:
                    a, b = count - 2, count - 1
                    if is_straight(places[0, a], places[1, a], places[0, b], places[1, b], x, y):
                        count -= 1
                places[0, count], places[1, count] = x, y
                joined[count] = True
                count += 1
                if not left[point]:  # closed
                    break
                left[point] = False
                after = neighbours[point, 0] if neighbours[point, 0] != before else neighbours[point, 1]
                point, before = after, point
            joined[count - 1] = False
    return count


@kernel
def _separate(points: Floats, segments: Ints, places: Floats, joined: NDArray[np.bool_]) -> int:
    """Write each segment as a chain of its own; the number of points is returned."""
    for g in range(len(segments)):
        for end in range(2):
            for axis in range(2):
                places[axis, 2 * g + end] = points[segments[g, end], axis]
        joined[2 * g] = True
    return 2 * len(segments)


@kernel
def _surround(places: Floats, near: NDArray[np.float32], circle: Floats) -> None:
    """Write the circle around points, and the points from its middle."""
    for axis in range(2):
        circle[axis] = 0.5 * (places[axis].min() + places[axis].max())
    square = 0.0
    for point in range(places.shape[1]):
        x, y = places[0, point] - circle[0], places[1, point] - circle[1]
        square = max(square, x * x + y * y)
        near[0, point], near[1, point] = x, y
    circle[2] = np.sqrt(square)
