"""The finite set of poses that the object may have."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from voa_core.checks import Floats, finite_array, frozen, unique_names
from voa_core.errors import InvalidInput
from voa_core.geometry import matrices_of_quaternions, quaternion_of_matrix, turn
from voa_core.stable_poses import StablePose


@dataclass(frozen=True, eq=False)
class PoseSet:
    """Finitely many poses of the object in the world frame (z up, the table at z = 0).

    Attributes:
        names: one per pose, all different.
        positions: (n, 3) of the object's frame, metres; None where only the names are known.
        quaternions_wxyz: (n, 4) unit quaternions, w first, or None.
        rotations: (n, 3, 3) rotation matrices, or None.
    """

    names: tuple[str, ...]
    positions: Floats | None
    quaternions_wxyz: Floats | None
    rotations: Floats | None

    def __len__(self) -> int:
        return len(self.names)

    def subset(self, index: NDArray[np.intp]) -> "PoseSet":
        """Select the poses at `index` (k,), in that order."""
        if self.positions is None or self.quaternions_wxyz is None or self.rotations is None:
            return PoseSet(tuple(self.names[p] for p in index), None, None, None)
        return PoseSet(
            tuple(self.names[p] for p in index),
            frozen(self.positions[index]),
            frozen(self.quaternions_wxyz[index]),
            frozen(self.rotations[index]),
        )

    @classmethod
    def named(cls, names: Sequence[str]) -> "PoseSet":
        """Make poses of which only the names are known, for predictions that are given as data; raises InvalidInput."""
        return cls(unique_names("pose", names), None, None, None)

    @classmethod
    def from_arrays(cls, names: Sequence[str], positions: ArrayLike, quaternions_wxyz: ArrayLike) -> "PoseSet":
        """Make poses from positions (n, 3) in metres and quaternions (n, 4), w first.

        Raises:
            InvalidInput: lengths differ, a name stands twice, a number is not finite, or a quaternion is far from unit
                length.
        """
        names = unique_names("pose", names)
        where = finite_array("position", positions, (len(names), 3))
        how = finite_array("quaternion_wxyz", quaternions_wxyz, (len(names), 4))
        rotations = matrices_of_quaternions(how)
        unit = how / np.linalg.norm(how, axis=1, keepdims=True)
        return cls(names, where, frozen(unit), frozen(rotations))


def generate(
    resting: Sequence[StablePose],
    yaws_rad: ArrayLike,
    positions_xy: ArrayLike,
    names: Sequence[str] | None = None,
) -> PoseSet:
    """Make a pose of every stable pose at every yaw at every position on the table.

    Args:
        resting: the stable poses, one per way to rest.
        yaws_rad: (y,) turns about the vertical through the object frame's origin.
        positions_xy: (k, 2) positions of the object frame's origin, metres.
        names: one per stable pose; default "S1", "S2", ...

    Returns:
        len(resting) * y * k poses, the position varying fastest, then the yaw; named "S1/30deg", with "/x,y" in
        millimetres where there are several positions.

    Raises:
        InvalidInput: there is no stable pose, yaw or position; two poses would have one name; or the number of names
            is not that of the stable poses.
    """
    yaws = finite_array("yaws_rad", yaws_rad, (None,))
    places = finite_array("positions_xy", positions_xy, (None, 2))
    if not (len(resting) and len(yaws) and len(places)):
        raise InvalidInput("pose set", "at least one stable pose, yaw and position", "none")
    labels = [f"S{i + 1}" for i in range(len(resting))] if names is None else list(names)
    if len(labels) != len(resting):
        raise InvalidInput("names", f"one per stable pose, {len(resting)}", str(len(labels)))
    made: list[tuple[str, list[float], Floats]] = []
    for label, rest in zip(labels, resting, strict=True):
        upright = matrices_of_quaternions(np.array([rest.quaternion_wxyz]))[0]
        for yaw in yaws:
            quaternion = quaternion_of_matrix(turn(float(yaw)) @ upright)
            for x, y in places:
                place = f"/{1e3 * x:g},{1e3 * y:g}" if len(places) > 1 else ""
                made.append((f"{label}/{np.degrees(yaw):g}deg{place}", [x, y, rest.position[2]], quaternion))
    all_names, positions, quaternions = zip(*made, strict=True)
    return PoseSet.from_arrays(all_names, positions, quaternions)
