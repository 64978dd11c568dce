"""The surface of a mesh: its moments, and a test if points lie on it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.jit import kernel
from voa_core.mistakes.picking import evenly
from voa_core.objects import Object
from voa_core.outlines import Ints

_SAMPLES = 64


@dataclass(frozen=True, eq=False)
class Surface:
    """The surface of a mesh in the object's frame, independent of its division into faces."""

    object_: Object

    @cached_property
    def samples(self) -> Floats:
        """Sample points of the surface, (k, 3) metres: up to 64 corners and 64 middles of faces, evenly selected."""
        corners = self.object_.vertices[np.unique(self.object_.faces)]
        middles = self.object_.vertices[self.object_.faces].mean(axis=1)
        return np.vstack([corners[evenly(len(corners), _SAMPLES)], middles[evenly(len(middles), _SAMPLES)]])

    @cached_property
    def moments(self) -> tuple[Floats, Floats]:
        """Middle (3,) and covariance (3, 3) of the surface, weighted by area, metres and square metres."""
        corners = self.object_.vertices[self.object_.faces]
        sides = corners[:, 1:] - corners[:, :1]
        areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        areas = np.maximum(areas, np.finfo(np.float64).tiny)  # a needle has no area, yet a middle
        shares = areas / areas.sum()
        middle = shares @ corners.mean(axis=1)
        offsets = corners - middle
        total = offsets.sum(axis=1)
        covariance = np.einsum("f,fki,fkj->ij", shares, offsets, offsets) + np.einsum(
            "f,fi,fj->ij", shares, total, total
        )
        return middle, covariance / 12.0

    @property
    def cost(self) -> int:
        """Upper limit of the bounding boxes that `holds` tests for the samples of a mesh of this size."""
        return len(self.samples) * len(self.object_.boxes[0])

    def holds(self, points: Floats, tolerance_m: float) -> bool:
        """True if every point (k, 3) lies within `tolerance_m` of the surface."""
        return bool(_on_surface(points, tolerance_m, self.object_.vertices, self.object_.faces, *self.object_.boxes))


@kernel
def _on_surface(
    points: Floats,
    tolerance: float,
    vertices: Floats,
    faces: NDArray[np.int32],
    boxed: Ints,
    centres: Floats,
    halves: Floats,
) -> bool:
    """True if every point is near a face; only the faces in boxes of `Object.boxes` near the point are tested."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        near = False
        for box in range(centres.shape[1]):
            if (
                abs(x - centres[0, box]) > halves[0, box] + tolerance
                or abs(y - centres[1, box]) > halves[1, box] + tolerance
                or abs(z - centres[2, box]) > halves[2, box] + tolerance
            ):
                continue
            for f in boxed[box]:
                if f < 0:
                    break
                a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
                if _square_distance(points[i], a, b, c) <= tolerance * tolerance:
                    near = True
                    break
            if near:
                break
        if not near:
            return False
    return True


@kernel
def _square_distance(p: Floats, a: Floats, b: Floats, c: Floats) -> float:
    """Squared distance of a point to a triangle, by the region in which it lies (Ericson, "Real-Time Collision
    Detection", 5.1.5): before a corner, before a side, or over the face.
    """
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for axis in range(3):
        side_b, side_c = b[axis] - a[axis], c[axis] - a[axis]
        d1 += side_b * (p[axis] - a[axis])
        d2 += side_c * (p[axis] - a[axis])
        d3 += side_b * (p[axis] - b[axis])
        d4 += side_c * (p[axis] - b[axis])
        d5 += side_b * (p[axis] - c[axis])
        d6 += side_c * (p[axis] - c[axis])
    over_a, over_b, over_c = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        to_b, to_c = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        to_b, to_c = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        to_b, to_c = 0.0, 1.0
    elif over_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        to_b, to_c = d1 / (d1 - d3), 0.0
    elif over_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        to_b, to_c = 0.0, d2 / (d2 - d6)
    elif over_a <= 0.0 and d4 >= d3 and d5 >= d6:
        to_c = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        to_b = 1.0 - to_c
    else:
        to_b, to_c = over_b / (over_a + over_b + over_c), over_c / (over_a + over_b + over_c)
    square = 0.0
    for axis in range(3):
        off = p[axis] - a[axis] - to_b * (b[axis] - a[axis]) - to_c * (c[axis] - a[axis])
        square += off * off
    return square
