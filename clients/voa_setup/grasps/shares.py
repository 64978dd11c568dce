"""Shares of displaced copies of the object that a hand grips."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.special import ndtri

from voa_fleet.world.frames import Floats
from voa_fleet.world.objects import GripperSetting
from voa_setup.grasps.closing import close_hands
from voa_setup.grasps.hands import Hands, inverse, joined
from voa_setup.grasps.surface import Surface

_R3 = (0.8191725133961645, 0.6710436067037893, 0.5497004779019703)
"""Steps of the additive sequence in the cube whose points stay far from each other."""


def displacements(count: int, xy_m: float, yaw_rad: float, seed: int) -> Floats:
    """Draw displacements (count, 3) of x, y and yaw from independent normal distributions.

    They are evenly spread: quantiles of an additive sequence in the cube, shifted at random.
    """
    shift = np.random.default_rng(seed).random(3)
    uniform = (shift + np.arange(count)[:, None] * _R3) % 1.0
    normal: Floats = ndtri(np.clip(uniform, 1e-4, 1.0 - 1e-4)) * [xy_m, xy_m, yaw_rad]
    return normal


def displaced(pose: Floats, displacement: Floats) -> Floats:
    """Move a pose (4, 4) by x, y and a yaw about the pose's position."""
    dx, dy, yaw = displacement
    motion = pose.copy()
    cosine, sine = np.cos(yaw), np.sin(yaw)
    motion[:2, :3] = np.array([[cosine, -sine], [sine, cosine]]) @ pose[:2, :3]
    motion[:2, 3] += dx, dy
    return motion


def gripped_shares(
    surface: Surface,
    poses: Floats,
    hands: Hands,
    gripper: GripperSetting,
    moves: Floats,
    friction: float,
    scouts: int | None = None,
) -> Floats:
    """Compute the share of displaced copies that each hand grips at each pose, (h, n).

    Args:
        surface: of the object.
        poses: (n, 4, 4).
        hands: in the world frame.
        gripper: opening and sizes of the fingers.
        moves: (j, 3), displacements of the object about its pose.
        friction: coefficient of both contacts.
        scouts: number of first copies of which one must be gripped, or the share counts as 0; None: all copies are
            tried. A few make many hands at many poses several times faster.
    """
    tree = KDTree(surface.points)
    farthest = np.linalg.norm(surface.points, axis=1).max()
    margin = np.linalg.norm(moves[:, :2], axis=1).max() + np.abs(moves[:, 2]).max() * farthest
    shares = np.zeros((len(hands), len(poses)))
    for column, pose in enumerate(poses):
        backs = [inverse(displaced(pose, move)) for move in moves]
        tried = np.flatnonzero(_within(tree, hands.moved(inverse(pose)), gripper, margin))
        gripped = _gripped(surface, hands[tried], backs[:scouts], gripper, friction)
        if scouts is not None:
            tried, gripped = tried[gripped > 0], gripped[gripped > 0]
            gripped = gripped + _gripped(surface, hands[tried], backs[scouts:], gripper, friction)
        shares[tried, column] = gripped / len(moves)
    return shares


def _gripped(
    surface: Surface, hands: Hands, backs: list[Floats], gripper: GripperSetting, friction: float
) -> NDArray[np.int64]:
    """Number of copies that each hand grips, (h,); `backs` are the motions (4, 4) from the world to each copy."""
    if not backs or not len(hands):
        return np.zeros(len(hands), dtype=np.int64)
    # All copies at once: few hands alone would leave most of the time to the calls.
    seen = joined([hands.moved(back) for back in backs])
    holds = close_hands(surface, seen, gripper, friction).holds.reshape(len(backs), len(hands))
    gripped: NDArray[np.int64] = holds.sum(axis=0, dtype=np.int64)
    return gripped


def _within(tree: KDTree, hands: Hands, gripper: GripperSetting, margin_m: float) -> NDArray[np.bool_]:
    """True for hands between whose fingers a point of the surface lies, if the object moves by up to `margin_m`."""
    length = gripper.finger_length_m
    centres = hands.tips - hands.rotations[:, :, 2] * length / 2.0
    radius = np.linalg.norm([gripper.opening_m, gripper.finger_width_m, length]) / 2.0 + margin_m
    distances, _ = tree.query(centres, distance_upper_bound=radius)
    near: NDArray[np.bool_] = np.isfinite(distances)
    return near
