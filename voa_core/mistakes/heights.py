"""Mistakes in the heights of poses: the object floats over the table, or is sunk into it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from voa_core.checks import Floats
from voa_core.mistakes.effort import Effort
from voa_core.mistakes.mistake import Mistake, length, listed
from voa_core.mistakes.picking import evenly
from voa_core.objects import Object
from voa_core.poses import PoseSet

REST_M = 0.002
_BLOCK = 4_000_000

Up = Literal["+Z", "+Y"]
"""Axis of a mesh file that was read as the vertical."""

_OTHER: dict[Up, tuple[Up, Floats]] = {
    "+Z": ("+Y", np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])),
    "+Y": ("+Z", np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])),
}
"""The other possible vertical axis, and the rotation of a mesh from its reading with the one to that with the other."""


@dataclass(frozen=True)
class Mesh:
    """The object of a scenario, and the axis of its file that became z."""

    object_: Object
    up: Up = "+Z"


def mistakes_of_heights(poses: PoseSet, mesh: Mesh, effort: Effort) -> list[Mistake]:
    """Find poses whose lowest point is more than 2 mm over or under the table, and a probable reason.

    Args:
        poses: with geometry.
        mesh: the object.
        effort: `pairs` limits the poses, `corners` the poses times the corners of the mesh.
    """
    if poses.rotations is None or poses.positions is None:
        return []
    corners = mesh.object_.vertices[np.unique(mesh.object_.faces)]
    index = evenly(len(poses), min(effort.pairs, max(1, effort.corners // len(corners))))
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
        f"{poses.names[index[worst]]!r} is {length(abs(lowest[worst]))} {side} it. Check position z, and where "
        "the origin of the mesh is"
    )
    mistakes = [Mistake("pose-height", detail, names)]
    other, turn = _OTHER[mesh.up]
    if (np.abs(lowest_points(corners @ turn.T, verticals, heights)) <= REST_M).all():
        detail = (
            f"the mesh was read with {mesh.up} up; with {other} up it would rest on the table at every pose. Upload it "
            f'again with up={other} if that is up in its file (in a scenario file, "up" stands beside "object")'
        )
        mistakes.append(Mistake("up-axis", detail, names))
    return mistakes


def lowest_points(corners: Floats, verticals: Floats, heights: Floats) -> Floats:
    """Height over the table of the lowest of the corners (v, 3) at each of k poses, (k,) metres.

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
    over_table: Floats = lowest[tilt_of_pose.reshape(-1)] + heights
    return over_table
