"""Poses that are one to a lidar and a gripper: the mesh lies in the same place at both, within a tolerance."""

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.mistakes.surface import Surface
from voa_core.objects import Object

SAME_M = 1e-3
"""Largest distance between the surfaces at two poses that count as one, metres: a fifth of a usual spread, and less
than a lidar's noise and than what a gripper minds."""
_SAMPLES = 600


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Comparisons of a mesh with itself at other poses."""

    surface: Surface
    samples: Floats

    def alike(self, first: Floats, other: Floats) -> bool:
        """True if the mesh lies in the same place within `SAME_M` at two poses, (4, 4) from object to world."""
        motion = np.linalg.inv(other) @ first
        for there in (motion, np.linalg.inv(motion)):
            if not self.surface.holds(self.samples @ there[:3, :3].T + there[:3, 3], SAME_M):
                return False
        return True


def symmetry_of(object_: Object) -> Symmetry:
    """Prepare comparisons of a mesh: 600 points spread evenly over its area, and its extreme points.

    Equal meshes give equal points: nothing is drawn at random.
    """
    corners = object_.vertices[object_.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    along = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    faces = np.searchsorted(np.cumsum(areas) / areas.sum(), along).clip(max=len(areas) - 1)
    # Additive recurrence with the plastic number: an even spread inside the triangles without random numbers.
    u, v = np.modf(np.outer([0.7548776662466927, 0.5698402909980532], np.arange(1, _SAMPLES + 1)))[0]
    u, v = np.where(u + v > 1.0, [1.0 - u, 1.0 - v], [u, v])
    picked = corners[faces]
    inside = picked[:, 0] + u[:, None] * (picked[:, 1] - picked[:, 0]) + v[:, None] * (picked[:, 2] - picked[:, 0])
    directions = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
    extremes = object_.vertices[np.unique((object_.vertices @ directions.T).argmax(axis=0))]
    return Symmetry(Surface(object_), np.vstack([inside, extremes]))
