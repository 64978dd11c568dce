"""Cuts of a solid into nearly convex pieces, the worst piece first, each time through a notch.

Of all planes through the deepest notches (along either face, and between the two) the one is taken whose parts have
hulls of the smallest total volume. Thin walls keep their thickness, because a wall is cut across and never filled.
"""

import heapq
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from voa_fleet.world.frames import Floats
from voa_setup.pieces.notches import Notches, notches_of
from voa_setup.pieces.solids import Piece, bounds_of, parts_of

MOST_PLANES, LEAST_PLANES = 24, 6
"""Numbers of planes that are tried for a cut of a piece with few faces, and of one with many."""
_FACES_TRIED = 36_000
"""Faces that a cut may handle in all its tries, which bounds the time for a mesh of many faces."""
_FILLED = 0.15
"""Share of `deepest_m` that the space between piece and hull may be thick on average."""

Plane = tuple[Floats, float]


@dataclass(order=True)
class _Open:
    """A piece that is still to be cut; the heap returns the one that is worst."""

    rank: tuple[float, int]
    solid: Any = field(compare=False)
    piece: Piece = field(compare=False)
    notches: Notches = field(compare=False)


def cut(solid: Any, deepest_m: float, most: int) -> list[Piece]:
    """Cut a closed solid into pieces of which each is nearly its convex hull.

    Args:
        solid: of manifold3d.
        deepest_m: depth of a notch below the hull that is left uncut, metres.
        most: number of pieces at which the cutting ends, however deep the notches are that remain.
    """
    waiting: list[_Open] = []
    done: list[Piece] = []
    counter = 0

    def add(part: Any) -> None:
        nonlocal counter
        counter += 1
        hull = part.hull()
        piece, notches = Piece(part.volume(), hull), notches_of(part, hull)
        filled = (hull.volume() - piece.volume_m3) / hull.surface_area()
        worst = max(notches.deepest_m, filled / _FILLED)
        if worst <= deepest_m:
            done.append(piece)
        else:
            heapq.heappush(waiting, _Open((-worst * math.sqrt(hull.surface_area()), counter), part, piece, notches))

    for part in parts_of(solid):
        add(part)
    while waiting and len(waiting) + len(done) < most:
        worst = heapq.heappop(waiting)
        parts = _best_cut(worst)
        if parts is None:
            done.append(worst.piece)
        for part in parts or []:
            add(part)
    return done + [entry.piece for entry in sorted(waiting)]


def _best_cut(entry: _Open) -> list[Any] | None:
    """Parts of the best cut; None where no plane divides the piece."""
    best: tuple[float, list[Any]] | None = None
    for normal, offset in _planes(entry):
        sides = entry.solid.split_by_plane(tuple(normal), offset)
        parts = [part for side in sides for part in parts_of(side)]
        if not parts:
            continue
        volume = sum(part.hull().volume() for part in parts)
        whole = len(parts) == 1 and volume > entry.piece.hull.volume() * (1.0 - 1e-6)
        if not whole and (best is None or volume < best[0] * (1.0 - 1e-9)):
            best = volume, parts
    return None if best is None else best[1]


def _planes(entry: _Open) -> list[Plane]:
    """Planes through the notches that weigh most, and through the piece's middle."""
    notches = entry.notches
    along = notches.end - notches.start
    weights = np.maximum(notches.depths, 1e-5) * np.linalg.norm(along, axis=1)
    planes: dict[tuple[float, ...], Plane] = {}
    count = max(LEAST_PLANES, min(MOST_PLANES, _FACES_TRIED // entry.solid.num_tri()))
    for index in np.argsort(-weights, kind="stable"):
        first, second = notches.normals[index]
        for normal in (np.cross(along[index], first + second), first, second):
            length = float(np.linalg.norm(normal))
            if length < 1e-12:
                continue
            unit = normal / length
            unit = unit if unit[np.argmax(np.abs(unit) > 1e-6)] > 0.0 else -unit
            offset = float(unit @ (notches.start[index] + notches.end[index]) / 2.0)
            planes.setdefault((*np.round(unit, 2).tolist(), round(offset, 4)), (unit, offset))
        if len(planes) >= count:
            break
    middle = bounds_of(entry.solid).mean(axis=0)
    return [*planes.values(), *((np.eye(3)[axis], float(middle[axis])) for axis in range(3))]
