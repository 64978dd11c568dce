"""Glyphs of a parallel gripper that has closed at a grasp: two fingers, the bar that joins them, and the approach."""

from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import Floats, tool_rotation
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry

_CORNERS = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
_SIDES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_BAR_M = 0.008
_TAIL = 0.6
"""Length of the arrow as a share of the fingers' length."""


@dataclass(frozen=True, eq=False)
class GripperGlyph:
    """A gripper as quadrilaterals and an arrow, in the world frame.

    Attributes:
        fingers: (12, 4, 3) sides of the two fingers, metres.
        bar: (6, 4, 3) sides of the bar that joins them.
        tail, tip: (3,) ends of the arrow along the approach; the tip is the tool centre point.
    """

    fingers: Floats
    bar: Floats
    tail: Floats
    tip: Floats

    @property
    def points(self) -> Floats:
        """Corners of all parts, (k, 3), metres."""
        return np.concatenate([self.fingers.reshape(-1, 3), self.bar.reshape(-1, 3), [self.tail]])


def gripper_glyph(geometry: GraspGeometry, gripper: GripperSetting) -> GripperGlyph:
    """Make the glyph of a grasp: the fingers touch an object of the grasp's width, else stand open."""
    tool = tool_rotation(geometry.approach, geometry.closing)
    centre = np.asarray(geometry.tool_centre_point, dtype=np.float64)
    width = gripper.opening_m if geometry.width_m is None else geometry.width_m
    length, thickness = gripper.finger_length_m, gripper.finger_thickness_m
    apart = (width + thickness) / 2.0
    size = np.array([thickness, gripper.finger_width_m, length])
    fingers = [_box(np.array([side * apart, 0.0, -length / 2.0]), size, tool, centre) for side in (1.0, -1.0)]
    span = np.array([width + 2.0 * thickness, gripper.finger_width_m, _BAR_M])
    bar = _box(np.array([0.0, 0.0, -length - _BAR_M / 2.0]), span, tool, centre)
    return GripperGlyph(np.concatenate(fingers), bar, centre - _TAIL * length * tool[:, 2], centre)


def _box(middle: Floats, size: Floats, tool: Floats, centre: Floats) -> Floats:
    """Sides (6, 4, 3) of a box in the tool's frame, in the world frame."""
    corners = (_CORNERS * size + middle) @ tool.T + centre
    return np.stack([corners[list(side)] for side in _SIDES])
