"""Groups of poses in which the object rests on the table in one way, apart from a turn and a shift on the table."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import matrix_of
from voa_msgs.scenarios import Pose

_SAME_DIRECTION = 1e-3
_SAME_HEIGHT_M = 1e-4
_TAIL = re.compile(r"[\s_\-./@]*[-+]?[\d.]*[\s_\-./@]*$")
"""End of a common beginning of names that is no word: separators and digits of the turn."""


@dataclass(frozen=True)
class PoseGroup:
    """Poses that differ by a turn about the vertical and a shift on the table.

    Attributes:
        name: the common beginning of their names, else the name of the first.
        poses: indices in the scenario's list.
    """

    name: str
    poses: tuple[int, ...]


def group_poses(poses: Sequence[Pose]) -> list[PoseGroup]:
    """Group poses by the direction of the object that points up, and the height of its origin; first listed first."""
    members: dict[tuple[float, ...], list[int]] = {}
    for index, pose in enumerate(poses):
        up = matrix_of(pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0))[2]
        height = (pose.position or (0.0, 0.0, 0.0))[2]
        key = next((key for key in members if _same(key, up.tolist(), height)), (*up.tolist(), height))
        members.setdefault(key, []).append(index)
    return [PoseGroup(_name([poses[index].name for index in group]), tuple(group)) for group in members.values()]


def _same(key: tuple[float, ...], up: Sequence[float], height: float) -> bool:
    near = np.abs(np.subtract(key[:3], up)).max() <= _SAME_DIRECTION
    return bool(near and abs(key[3] - height) <= _SAME_HEIGHT_M)


def _name(names: Sequence[str]) -> str:
    """Name a group after the common beginning of its members' names, without the digits of a turn at its end."""
    start = names[0]
    for name in names[1:]:
        while not name.startswith(start):
            start = start[:-1]
    word = _TAIL.sub("", start)
    return word if word and len(names) > 1 else names[0]
