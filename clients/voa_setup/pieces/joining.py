"""Joins of neighbouring pieces whose joint convex hull hardly adds volume: fewer pieces make a faster simulation."""

import heapq

import numpy as np

from voa_fleet.world.frames import Floats
from voa_setup.pieces.solids import Piece, bounds_of, joint_hull

_TOUCH_M = 1e-5


def join(pieces: list[Piece], thickest_m: float) -> list[Piece]:
    """Join neighbours, best pair first, while the space between the parts and their hull stays thin.

    Args:
        pieces: of one object.
        thickest_m: largest average thickness of that space, metres: its volume over the hull's surface.
    """
    alive = dict(enumerate(pieces))
    bounds = {index: bounds_of(piece.hull) for index, piece in alive.items()}
    waiting: list[tuple[float, int, int]] = []

    def consider(first: int, second: int) -> None:
        if not _touch(bounds[first], bounds[second]):
            return
        hull = joint_hull(alive[first].hull, alive[second].hull)
        added = hull.volume() - alive[first].volume_m3 - alive[second].volume_m3
        thickness = added / hull.surface_area()
        if thickness <= thickest_m:
            heapq.heappush(waiting, (thickness, first, second))

    for second in alive:
        for first in range(second):
            consider(first, second)
    while waiting:
        _, first, second = heapq.heappop(waiting)
        if first not in alive or second not in alive:
            continue
        hull = joint_hull(alive[first].hull, alive[second].hull)
        joined = len(bounds)
        bounds[joined] = bounds_of(hull)
        volume = alive.pop(first).volume_m3 + alive.pop(second).volume_m3
        others = list(alive)
        alive[joined] = Piece(volume, hull)
        for other in others:
            consider(other, joined)
    return list(alive.values())


def _touch(first: Floats, second: Floats) -> bool:
    """True if two axis-parallel boxes (2, 3) touch."""
    return bool((np.maximum(first[0], second[0]) <= np.minimum(first[1], second[1]) + _TOUCH_M).all())
