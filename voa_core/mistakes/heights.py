"""Poses at which the object does not rest on the table: it floats over it, or is sunk into it."""

import numpy as np

from voa_core.checks import Floats
from voa_core.mistakes.found import Mistake, listed
from voa_core.mistakes.picking import evenly
from voa_core.objects import Object
from voa_core.poses import PoseSet

REST_M = 0.002
_MOST_PRODUCTS = 20_000_000  # heights of corners that are computed where the cost is bounded
_BLOCK = 4_000_000
_UPRIGHT = {
    "+Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "+Z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
"""The turn of the mesh that it should have had, if its file's `up` was this one; `+Z` undoes the turn of `+Y`."""


def mistakes_of_heights(poses: PoseSet, object_: Object, most: int | None) -> list[Mistake]:
    """Find poses whose lowest point is more than 2 mm over or under the table, and why that may be.

    Args:
        poses: with geometry.
        object_: the mesh.
        most: poses to look at; None: all.
    """
    if poses.rotations is None or poses.positions is None:
        return []
    corners = object_.vertices[np.unique(object_.faces)]
    index = evenly(len(poses), most)
    if most is not None:
        index = index[evenly(len(index), max(1, _MOST_PRODUCTS // len(corners)))]
    verticals, heights = poses.rotations[index, 2, :], poses.positions[index, 2]
    lowest = lowest_points(corners, verticals, heights)
    wrong = index[np.abs(lowest) > REST_M]
    if not wrong.size:
        return []
    names = tuple(poses.names[p] for p in wrong)
    worst = int(np.argmax(np.abs(lowest)))
    side = "over" if lowest[worst] > 0.0 else "under"
    detail = (
        f"at {listed('pose', names)} the object does not rest on the table (z = 0): its lowest point at "
        f"{poses.names[index[worst]]!r} is {1e3 * abs(lowest[worst]):.4g} mm {side} it. Check position z, and where "
        "the origin of the mesh is"
    )
    found = [Mistake("pose-height", detail, names)]
    for up, turn in _UPRIGHT.items():
        if (np.abs(lowest_points(corners @ turn.T, verticals, heights)) <= REST_M).all():
            detail = f"every pose would rest on the table with a mesh uploaded with up {up!r}: which axis is up in it?"
            found.append(Mistake("up-axis", detail, names))
    return found


def lowest_points(corners: Floats, verticals: Floats, heights: Floats) -> Floats:
    """Height over the table of the lowest corner (v, 3) at each of k poses, metres, (k,).

    Args:
        corners: in the object's frame.
        verticals: (k, 3) the last row of each pose's rotation: the world's vertical in the object's frame.
        heights: (k,) of the object's frame over the table.
    """
    tilts, tilt_of_pose = np.unique(np.round(verticals, 12), axis=0, return_inverse=True)
    lowest = np.zeros(len(tilts))
    at_once = max(1, _BLOCK // len(corners))
    for start in range(0, len(tilts), at_once):
        lowest[start : start + at_once] = (tilts[start : start + at_once] @ corners.T).min(axis=1)
    found: Floats = lowest[tilt_of_pose.reshape(-1)] + heights
    return found
