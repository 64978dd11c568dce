"""Hands: places of a parallel gripper, and the room that its fingers and palm take."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats, tool_rotation
from voa_fleet.world.gripper import PALM_M
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry

PALM_BEYOND_FINGERS_M = 0.004
"""Distance by which the palm is wider than the open fingers, on each side."""
TABLE_CLEARANCE_M = 0.002
"""Smallest distance between a proposed hand and the table."""


@dataclass(frozen=True, eq=False)
class Hands:
    """Places of open hands in one frame.

    Attributes:
        rotations: (h, 3, 3); the columns are the closing direction, the direction across, and the approach.
        tips: (h, 3), the tool centre points, metres.
    """

    rotations: Floats
    tips: Floats

    def __len__(self) -> int:
        return len(self.tips)

    def __getitem__(self, index: NDArray[np.intp] | NDArray[np.bool_]) -> "Hands":
        return Hands(self.rotations[index], self.tips[index])

    def moved(self, motion: Floats) -> "Hands":
        """Return the hands after a rigid motion, a matrix (4, 4)."""
        return Hands(motion[:3, :3] @ self.rotations, self.tips @ motion[:3, :3].T + motion[:3, 3])

    def shifted(self, along: Floats, axis: int) -> "Hands":
        """Return the hands, each shifted along its own axis by `along` (h,), metres."""
        return Hands(self.rotations, self.tips + along[:, None] * self.rotations[:, :, axis])


def joined(parts: list[Hands]) -> Hands:
    """Join lists of hands, at least one, in their order."""
    return Hands(np.concatenate([part.rotations for part in parts]), np.concatenate([part.tips for part in parts]))


def hands_of(grasps: list[GraspGeometry]) -> Hands:
    """Return the hands of grasps, in their order."""
    rotations = [tool_rotation(grasp.approach, grasp.closing) for grasp in grasps]
    tips = [grasp.tool_centre_point for grasp in grasps]
    return Hands(np.array(rotations).reshape(-1, 3, 3), np.array(tips).reshape(-1, 3))


def inverse(motion: Floats) -> Floats:
    """Return the inverse of a rigid motion, (4, 4)."""
    back = np.eye(4)
    back[:3, :3] = motion[:3, :3].T
    back[:3, 3] = -motion[:3, :3].T @ motion[:3, 3]
    return back


def palm_half_m(gripper: GripperSetting) -> float:
    """Half of the palm's width along the closing direction, metres."""
    return gripper.opening_m / 2.0 + gripper.finger_thickness_m + PALM_BEYOND_FINGERS_M


def heights(hands: Hands, gripper: GripperSetting) -> Floats:
    """Heights of the lowest corner of fingers and palm over the table, (h,), metres; hands in the world frame.

    No hand approaches from below, so that this is the lowest height of its approach too.
    """
    reach = gripper.opening_m / 2.0 + gripper.finger_thickness_m
    boxes = (
        (reach, gripper.finger_width_m / 2.0, -gripper.finger_length_m, 0.0),
        (palm_half_m(gripper), gripper.palm_width_m / 2.0, -gripper.finger_length_m - PALM_M, -gripper.finger_length_m),
    )
    down = hands.rotations[:, 2, :]
    lows = [
        hands.tips[:, 2]
        - np.abs(down[:, 0]) * x
        - np.abs(down[:, 1]) * y
        + np.minimum(down[:, 2] * z0, down[:, 2] * z1)
        for x, y, z0, z1 in boxes
    ]
    lowest: Floats = np.minimum(*lows)
    return lowest
