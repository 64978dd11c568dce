"""Closing of hands on a surface: does the open hand get there, and are the contacts antipodal?

Two contacts with friction hold an object if the line between them lies in the friction cones of both: the antipodal
condition of grasps with two fingers. Fingers are flat and wide, so a contact is a patch of the surface.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.gripper import PALM_M
from voa_fleet.world.kinematics import APPROACH_M
from voa_fleet.world.objects import GripperSetting
from voa_setup.grasps.hands import Hands, palm_half_m
from voa_setup.grasps.surface import Surface

Bools = NDArray[np.bool_]
Indices = NDArray[np.intp]
Singles = NDArray[np.float32]

THINNEST_M = 0.0015
"""Width below which the fingers hold nothing."""
PATCH_M = 0.001
"""Depth of the patch of surface that a finger touches first."""
YIELD_M = 0.0025
"""Depth of the patch that a finger touches in the end: pads give, and the object turns until faces are parallel."""
_FACING_SHARE, _FACING_MARGIN = 0.5, np.tan(np.radians(15.0))
"""Share of a patch whose normals must lie within 15 degrees of the friction cone: a bare edge slips."""
_ENTRIES = 15_000


@dataclass(frozen=True, eq=False)
class Closed:
    """Results of closing hands.

    Attributes:
        free: (h,), True where neither fingers nor palm meet the object on the way and at the end.
        holds: (h,), True where the hand is free and its two contacts are antipodal.
        widths_m: (h,), of the object between the fingers; 0 where nothing is there.
        middles_m: (h,), of the object between the fingers, from the hand's middle along the closing direction.
    """

    free: Bools
    holds: Bools
    widths_m: Floats
    middles_m: Floats


def close_hands(
    surface: Surface, hands: Hands, gripper: GripperSetting, friction: float, clearance_m: float = 0.0
) -> Closed:
    """Approach with open hands along straight lines, and close them on a surface that stays where it is.

    Args:
        surface: of the object.
        hands: at the end of their approach, in the object's frame.
        gripper: opening and sizes of the fingers.
        friction: coefficient mu; the friction cones have a half angle of atan(mu).
        clearance_m: by how much the open fingers are taken to be closer to each other than they are.
    """
    closed = Closed(*(np.zeros(len(hands), kind) for kind in (bool, bool, float, float)))
    # Most hands that meet the object meet a few of its points already, which takes far less time to find.
    coarse = surface.coarse
    passing = [
        rows[_free(_near(coarse, hands[rows], gripper), gripper, clearance_m, len(rows))]
        for rows in _batches(np.arange(len(hands)), coarse)
    ]
    for rows in _batches(np.concatenate(passing), surface) if passing else ():
        part = _close(surface, hands[rows], gripper, friction, clearance_m)
        closed.free[rows], closed.holds[rows] = part.free, part.holds
        closed.widths_m[rows], closed.middles_m[rows] = part.widths_m, part.middles_m
    return closed


def _batches(hands: Indices, surface: Surface) -> list[Indices]:
    """Divide hands so that a batch and the groups of a surface have at most `_ENTRIES` pairs."""
    size = max(1, _ENTRIES // len(surface.centres))
    return [hands[start : start + size] for start in range(0, len(hands), size)]


@dataclass(frozen=True, eq=False)
class _Entries:
    """Points near hands, sorted by hand: indices, and coordinates in the hand's frame."""

    hand: Indices
    point: Indices
    x: Singles
    y: Singles
    z: Singles

    def where(self, mask: Bools) -> "_Entries":
        return _Entries(self.hand[mask], self.point[mask], self.x[mask], self.y[mask], self.z[mask])


def _close(surface: Surface, hands: Hands, gripper: GripperSetting, friction: float, clearance_m: float) -> Closed:
    count, reach = len(hands), gripper.opening_m / 2.0
    near = _near(surface, hands, gripper)
    free = _free(near, gripper, clearance_m, count)
    in_width, above_palm = np.abs(near.y) <= gripper.finger_width_m / 2.0, near.z >= -gripper.finger_length_m
    between = near.where(in_width & (np.abs(near.x) < reach) & above_palm & free[near.hand])
    low, high = np.zeros(count), np.zeros(count)
    hand, starts = _runs(between.hand)
    if len(hand):
        high[hand] = np.maximum.reduceat(between.x, starts)
        low[hand] = np.minimum.reduceat(between.x, starts)
    above, below = high[between.hand] - between.x, between.x - low[between.hand]
    right, left = (_facing(between.where(depth <= PATCH_M), surface, hands, friction) for depth in (above, below))
    upper, lower = (_Patch.of(between.where(depth <= YIELD_M), count) for depth in (above, below))
    widths = high - low
    holds = free & (widths >= THINNEST_M) & right & left & _opposite(upper, lower, friction * widths)
    return Closed(free, holds, widths, (high + low) / 2.0)


def _free(near: _Entries, gripper: GripperSetting, clearance_m: float, count: int) -> Bools:
    """True for hands of which neither fingers nor palm meet a point, (count,)."""
    reach, aside, across = gripper.opening_m / 2.0, np.abs(near.x), np.abs(near.y)
    outer = reach + gripper.finger_thickness_m
    in_finger = (across <= gripper.finger_width_m / 2.0) & (aside >= reach - clearance_m) & (aside <= outer)
    in_palm = (across <= gripper.palm_width_m / 2.0) & (near.z <= -gripper.finger_length_m)
    free = np.ones(count, dtype=bool)
    free[near.hand[in_finger | in_palm]] = False
    return free


def _near(surface: Surface, hands: Hands, gripper: GripperSetting) -> _Entries:
    """Points in the room that hands pass through, from the tips back to where the approach starts."""
    half = np.array([palm_half_m(gripper), max(gripper.finger_width_m, gripper.palm_width_m) / 2.0], dtype=np.float32)
    back = np.float32(gripper.finger_length_m + PALM_M + APPROACH_M)
    axes = hands.rotations.transpose(0, 2, 1).astype(np.float32)
    offsets = np.einsum("hij,hj->hi", hands.rotations.transpose(0, 2, 1), hands.tips).astype(np.float32)
    centres = axes @ surface.centres.T.astype(np.float32) - offsets[:, :, None]
    radii = surface.radii.astype(np.float32)
    mask = (np.abs(centres[:, :2]) <= half[:, None] + radii).all(axis=1)
    mask &= (centres[:, 2] <= radii) & (centres[:, 2] >= -back - radii)
    hand, group = np.nonzero(mask)
    members = surface.members[:, group]
    x, y, z = (_along(members, axes[hand, axis]) - offsets[hand, axis, None] for axis in range(3))
    inside = (np.abs(x) <= half[0]) & (np.abs(y) <= half[1]) & (z <= 0.0) & (z >= -back)
    pair, _ = np.nonzero(inside)
    return _Entries(hand[pair], surface.groups[group][inside], x[inside], y[inside], z[inside])


def _along(points: Singles, axes: Singles) -> Singles:
    """Coordinates (s, g) of groups of points (3, s, g) along an axis each (s, 3)."""
    along: Singles = points[0] * axes[:, :1]
    along += points[1] * axes[:, 1:2]
    along += points[2] * axes[:, 2:]
    return along


def _runs(hand: Indices) -> tuple[Indices, Indices]:
    """Hands that occur in a sorted list, and where each begins."""
    starts = np.flatnonzero(np.diff(hand, prepend=-1))
    return hand[starts], starts


def _facing(entries: _Entries, surface: Surface, hands: Hands, friction: float) -> Bools:
    """True for hands whose finger touches a patch that faces it: its mean normal lies in the friction cone, (h,)."""
    count = len(hands)
    normals = np.einsum("ki,kij->kj", surface.normals[entries.point], hands.rotations[entries.hand])
    normals *= np.where(normals[:, :1] < 0.0, -1.0, 1.0)
    number = np.bincount(entries.hand, minlength=count)
    nearly = normals[:, 0] >= _cosine((friction + _FACING_MARGIN) / (1.0 - friction * _FACING_MARGIN))
    share = np.bincount(entries.hand, weights=nearly, minlength=count) / np.maximum(number, 1)
    summed = np.zeros((count, 3))
    hand, starts = _runs(entries.hand)
    if len(hand):
        summed[hand] = np.add.reduceat(normals, starts)
    facing: Bools = (share >= _FACING_SHARE) & (summed[:, 0] >= _cosine(friction) * np.linalg.norm(summed, axis=1))
    return facing


def _cosine(tangent: float) -> float:
    return 1.0 / float(np.hypot(1.0, tangent))


@dataclass(frozen=True, eq=False)
class _Patch:
    """Patches that the fingers of one side touch: mean and extent across the closing direction, (h, 2) each."""

    mean: Floats
    low: Floats
    high: Floats

    @classmethod
    def of(cls, entries: _Entries, count: int) -> "_Patch":
        places = np.column_stack([entries.y, entries.z]).astype(np.float64)
        mean, low, high = (np.zeros((count, 2)) for _ in range(3))
        hand, starts = _runs(entries.hand)
        if len(hand):
            mean[hand] = np.add.reduceat(places, starts) / np.bincount(entries.hand, minlength=count)[hand, None]
            low[hand] = np.minimum.reduceat(places, starts)
            high[hand] = np.maximum.reduceat(places, starts)
        return cls(mean, low, high)


def _opposite(right: _Patch, left: _Patch, offset: Floats) -> Bools:
    """True where a line between the patches lies in both cones: it may leave the closing direction by `offset` (h,)."""
    overlap = ((right.low <= left.high) & (left.low <= right.high)).all(axis=1)
    close: Bools = np.linalg.norm(right.mean - left.mean, axis=1) <= offset
    return overlap | close
