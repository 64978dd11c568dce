"""Kinds of grasp as coordinates: a rim from above, a handle from outside, a body from the side lie apart."""

import numpy as np

from voa_fleet.world.frames import Floats
from voa_fleet.world.objects import GripperSetting
from voa_setup.grasps.hands import Hands
from voa_setup.grasps.surface import Surface

_PLACE, _DIRECTION, _SIDE = 1.0, 0.7, 0.3


def kind_features(surface: Surface, pose: Floats, hands: Hands, widths_m: Floats, gripper: GripperSetting) -> Floats:
    """Compute coordinates (h, f) in which grasps of the same kind lie near each other.

    They are the distance from the object's axis, the height, the directions of approach and closing against the
    vertical and against the direction away from the axis, and the width between the fingers; and, with less weight,
    the place on the object. The distance of clearly different kinds is about 1.

    Args:
        surface: of the object.
        pose: of the object, (4, 4); its axis is the vertical through the mean of the surface.
        hands: in the world frame, (h).
        widths_m: of the object between the fingers, (h,).
        gripper: its opening.
    """
    half = surface.size_m / 2.0
    centre = pose[:3, :3] @ surface.points.mean(axis=0) + pose[:3, 3]
    place = (hands.tips - centre) / half
    distance = np.linalg.norm(place[:, :2], axis=1)
    outward = place * [1.0, 1.0, 0.0] / np.maximum(distance, 0.1)[:, None]
    closing, approach = hands.rotations[:, :, 0], hands.rotations[:, :, 2]
    directions = (
        approach[:, 2],
        (approach * outward).sum(axis=1),
        np.abs(closing[:, 2]),
        np.abs((closing * outward).sum(axis=1)),
    )
    return np.column_stack(
        [
            _PLACE * distance,
            _PLACE * place[:, 2],
            _DIRECTION * np.column_stack(directions),
            widths_m / gripper.opening_m,
            _SIDE * place @ pose[:3, :3],
        ]
    )
