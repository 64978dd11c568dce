"""Points on a mesh's surface, with their normals: what a gripper can touch."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh

SPACING_M = 0.003
"""Mean distance between neighbouring points, while their number stays between `FEWEST` and `MOST`."""
FEWEST, MOST = 1500, 4500
GROUP = 12
"""Most points of a group, which are tested together."""
_COARSE = 8
_R2 = (0.7548776662466927, 0.5698402909980532)
"""Steps of the additive sequence in the plane whose points stay far from each other."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Points on a surface, in the object's frame.

    Attributes:
        points: (k, 3), metres.
        normals: (k, 3), unit vectors; their sign is that of the mesh, and closing a hand does not depend on it.
        groups: (g, GROUP), indices of points that lie near each other; -1 where a group has fewer.
        members: (3, g, GROUP), single precision, x, y and z of these points; not a number where a group has fewer.
        centres: (g, 3), of balls around the groups.
        radii: (g,), of these balls, metres.
    """

    points: Floats
    normals: Floats
    groups: NDArray[np.intp]
    members: NDArray[np.float32]
    centres: Floats
    radii: Floats

    @classmethod
    def of(cls, points: Floats, normals: Floats) -> "Surface":
        """Group points (k, 3), with normals (k, 3)."""
        groups = np.array([np.pad(part, (0, GROUP - len(part)), constant_values=-1) for part in _split(points)])
        members = np.where(groups[..., None] >= 0, points[groups], np.nan)
        centres = np.nanmean(members, axis=1)
        radii = np.nanmax(np.linalg.norm(members - centres[:, None], axis=2), axis=1)
        return cls(points, normals, groups, members.transpose(2, 0, 1).astype(np.float32), centres, radii)

    @cached_property
    def coarse(self) -> "Surface":
        """Every eighth point, as a surface of its own: where a hand meets it, it meets the whole surface."""
        return Surface.of(self.points[::_COARSE], self.normals[::_COARSE])

    @property
    def centre(self) -> Floats:
        """Centre of the box around the points, (3,)."""
        middle: Floats = (self.points.min(axis=0) + self.points.max(axis=0)) / 2.0
        return middle

    @property
    def size_m(self) -> float:
        """Diagonal of the box around the points, metres."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


def sample_surface(mesh: Mesh, seed: int, most: int = MOST) -> Surface:
    """Sample points of a mesh's surface, evenly by area: a point every `SPACING_M` or so.

    Systematic sampling over the summed areas of the faces; within a face, points of an additive sequence.

    Args:
        mesh: of any number of faces; faces without area get no points.
        seed: of the offsets.
        most: largest number of points.

    Raises:
        ValueError: the mesh has no area.
    """
    corners = mesh.vertices[mesh.faces]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(crosses, axis=1)
    summed = np.cumsum(doubled)
    if not len(summed) or summed[-1] <= 0.0:
        raise ValueError(f"expected a mesh with area, got {len(doubled)} faces without")
    count = int(np.clip(summed[-1] / 2.0 / SPACING_M**2, min(FEWEST, most), most))
    rng = np.random.default_rng(seed)
    ticks = (np.arange(count) + rng.random()) / count * summed[-1]
    faces = np.minimum(np.searchsorted(summed, ticks), len(doubled) - 1)
    u, v = ((rng.random() + np.arange(count) * step) % 1.0 for step in _R2)
    # A square becomes a triangle of evenly spread points if its first coordinate is taken to the root.
    u = np.sqrt(u)
    first, second, third = corners[faces].transpose(1, 0, 2)
    points = (1.0 - u)[:, None] * first + (u * (1.0 - v))[:, None] * second + (u * v)[:, None] * third
    return Surface.of(points, crosses[faces] / doubled[faces, None])


def _split(points: Floats) -> list[NDArray[np.intp]]:
    """Halve points (k, 3) along their longest extent until no part has more than `GROUP`; indices."""
    parts, small = [np.arange(len(points))], []
    while parts:
        part = parts.pop()
        if len(part) <= GROUP:
            small.append(part)
            continue
        axis = int(np.ptp(points[part], axis=0).argmax())
        ordered = part[np.argsort(points[part, axis], kind="stable")]
        parts += [ordered[: len(part) // 2], ordered[len(part) // 2 :]]
    return small
