"""Views of the world along a direction: points in three dimensions become points of a picture."""

from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import Floats
from voa_msgs.grasp_geometry import GraspGeometry

_HORIZONTAL = 0.1
"""Length of the horizontal part of a unit vector from which it counts as a direction in the plane."""


@dataclass(frozen=True, eq=False)
class View:
    """A view without perspective.

    Attributes:
        right, up: (3,) unit vectors of the world that point right and up in the picture.
        right_label, up_label: names of the picture's axes.
    """

    right: Floats
    up: Floats
    right_label: str
    up_label: str

    @property
    def toward(self) -> Floats:
        """Unit vector (3,) from the picture toward the viewer."""
        return np.cross(self.right, self.up)

    def project(self, points: Floats) -> Floats:
        """Project points (..., 3) to the picture: (..., 2), metres right and up."""
        projected: Floats = points @ np.column_stack([self.right, self.up])
        return projected


def front_view() -> View:
    """View along the world's +y, from the south: x points right, z up."""
    return View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), "x", "z")


def top_view() -> View:
    """View from above: x points right, y up."""
    return View(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), "x", "y")


def view_across_fingers(geometry: GraspGeometry) -> View:
    """View from the side, z up, in which both fingers of a grasp are seen apart.

    The picture's right is the horizontal part of the closing direction; for fingers that close vertically it is that
    of the approach, and x where neither has one.
    """
    for direction in (geometry.closing, geometry.approach):
        vector = np.asarray(direction, dtype=np.float64)
        unit = vector / np.linalg.norm(vector)
        length = float(np.hypot(unit[0], unit[1]))
        if length >= _HORIZONTAL:
            right = np.array([unit[0], unit[1], 0.0]) / length
            # Of the two directions along the line, x (else y) points right, so that pictures of turned poses agree.
            right = right if (round(right[0], 6), round(right[1], 6)) > (0.0, 0.0) else -right
            return View(right, np.array([0.0, 0.0, 1.0]), _name(right), "z")
    return front_view()


def _name(right: Floats) -> str:
    """Name a horizontal direction: "x", "y", or its angle from x in degrees."""
    angle = round(float(np.degrees(np.arctan2(right[1], right[0]))))
    return {0: "x", 90: "y"}.get(angle, f"{angle}° from x")
