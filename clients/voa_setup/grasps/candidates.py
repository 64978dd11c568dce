"""Candidate hands from antipodal pairs of surface points.

A pair of points is antipodal if the line between them lies in the friction cones of both: fingers that close along
the line do not slip. Hands approach such a pair from above, from the side and at a slant, perpendicular to the line.
"""

import math

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.objects import GripperSetting
from voa_setup.grasps.closing import THINNEST_M
from voa_setup.grasps.cover import thin
from voa_setup.grasps.hands import TABLE_CLEARANCE_M, Hands, heights, joined
from voa_setup.grasps.surface import Surface

CLEARANCE_M = 0.0015
"""Distance that each open finger of a candidate keeps from the object."""
STARTS, PAIRS = 1000, 400
"""Surface points from which pairs begin, and pairs that are kept: those that differ most."""
_WIDTHS = 3
"""Ranges of width of which a start may give a pair each: a wall, a rod and a whole body can meet in one point."""
_LEVEL = math.sin(math.radians(20.0))
"""Steepest closing line that counts as level, and least steep that counts as upright, as the sine of the angle."""
_DEPTHS_M = (0.003, 0.012, 0.025)
"""Distances of the fingertips beyond the contacts."""
_HIGHEST_LIFT_M = 0.03
"""Largest height by which a hand that would meet the table is lifted."""


def antipodal_pairs(
    surface: Surface,
    widest_m: float,
    friction: float,
    rng: np.random.Generator,
    starts: int = STARTS,
    most: int = PAIRS,
) -> tuple[Floats, Floats]:
    """Pair surface points whose connecting line lies in the friction cones of both.

    Args:
        surface: of the object.
        widest_m: largest distance of a pair.
        friction: coefficient mu; the cones have a half angle of atan(mu).
        rng: draws the points from which pairs begin.
        starts: number of these points.
        most: pairs to keep, as different from each other as they can be.

    Returns:
        First and second point of every pair, (p, 3) each.
    """
    count = len(surface.points)
    begin = rng.choice(count, size=min(starts, count), replace=False)
    pairs: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
    points, normals = surface.points.astype(np.float32), surface.normals.astype(np.float32)
    inner = (points * normals).sum(axis=1)
    for part in np.array_split(begin, max(1, len(begin) // 200)):
        # (a - b) . n and |a - b|^2 from products of matrices.
        squared = (points[part] ** 2).sum(axis=1)[:, None] + (points**2).sum(axis=1) - 2.0 * points[part] @ points.T
        distance = np.sqrt(np.maximum(squared, 0.0))
        at_start = np.abs(inner[part][:, None] - normals[part] @ points.T)
        at_end = np.abs(inner - points[part] @ normals.T)
        narrow = distance / math.hypot(1.0, friction)
        valid = (at_start >= narrow) & (at_end >= narrow) & (distance >= THINNEST_M) & (distance <= widest_m)
        # Straight pairs first, with some chance for others.
        merit = np.where(valid, (at_start + at_end) / np.maximum(distance, THINNEST_M), -np.inf)
        merit += 0.1 * rng.random(merit.shape, dtype=np.float32)
        for low in range(_WIDTHS):
            in_range = (distance > widest_m * low / _WIDTHS) & (distance <= widest_m * (low + 1) / _WIDTHS)
            ranked = np.where(in_range, merit, -np.inf)
            best = ranked.argmax(axis=1)
            exists = np.isfinite(ranked[np.arange(len(part)), best])
            pairs.append((part[exists], best[exists]))
    first, second = (surface.points[np.concatenate([pair[side] for pair in pairs])] for side in (0, 1))
    kept = np.array(thin(np.ones(len(first)), _pair_features(surface, first, second, widest_m), most), dtype=np.intp)
    return first[kept], second[kept]


def _pair_features(surface: Surface, first: Floats, second: Floats, widest_m: float) -> Floats:
    """Coordinates (p, f) of pairs in which rims, rods and bodies lie apart, however small their area."""
    line = second - first
    width = np.linalg.norm(line, axis=1)[:, None]
    line /= width
    lines = np.einsum("pi,pj->pij", line, line).reshape(-1, 9)
    return np.column_stack([(first + second) / surface.size_m, 0.5 * lines, width / widest_m])


def candidate_hands(first: Floats, second: Floats, gripper: GripperSetting) -> Hands:
    """Place hands at antipodal pairs, in the world frame and clear of the table.

    Args:
        first, second: the pairs' points, (p, 3), with the object at its pose.
        gripper: opening and sizes of the fingers.
    """
    line = second - first
    line /= np.linalg.norm(line, axis=1)[:, None]
    middle = (first + second) / 2.0
    level, upright = np.abs(line[:, 2]) <= _LEVEL, np.abs(line[:, 2]) >= math.cos(math.asin(_LEVEL))
    ways = [(middle[level], *way) for way in _level_approaches(line[level])]
    ways += [(middle[upright], *way) for way in _upright_approaches(int(upright.sum()))]
    hands = joined([_hands(*way, depth, gripper) for way in ways for depth in _DEPTHS_M])
    return hands[heights(hands, gripper) >= TABLE_CLEARANCE_M - 1e-9]


def _level_approaches(line: Floats) -> list[tuple[Floats, Floats]]:
    """Closing and approach directions of level closing lines (p, 3): from above, from both sides, and between."""
    level = line * [1.0, 1.0, 0.0]
    level /= np.linalg.norm(level, axis=1)[:, None]
    side = np.column_stack([-level[:, 1], level[:, 0], np.zeros(len(level))])
    down = np.broadcast_to([0.0, 0.0, -1.0], side.shape)
    slant = math.sqrt(0.5)
    return [(level, way) for way in (down, side, -side, slant * (down + side), slant * (down - side))]


def _upright_approaches(count: int) -> list[tuple[Floats, Floats]]:
    """Closing and approach directions of upright closing lines: from eight sides."""
    up = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    bearings = np.arange(8) * math.pi / 4.0
    return [(up, np.broadcast_to([-math.cos(angle), -math.sin(angle), 0.0], (count, 3))) for angle in bearings]


def _hands(middle: Floats, closing: Floats, approach: Floats, depth_m: float, gripper: GripperSetting) -> Hands:
    """Hands (p) with their fingertips beyond the middle of the pair, lifted where they would meet the table."""
    hands = Hands(np.stack([closing, np.cross(approach, closing), approach], axis=2), middle + depth_m * approach)
    lift = np.clip(TABLE_CLEARANCE_M - heights(hands, gripper), 0.0, _HIGHEST_LIFT_M)
    return Hands(hands.rotations, hands.tips + lift[:, None] * [0.0, 0.0, 1.0])
