"""Meshes as solids of manifold3d, whose cuts are exact."""

from dataclasses import dataclass
from typing import Any

import manifold3d
import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh

LEAST_M3 = 1e-10
"""Volume below which a piece is dropped, a tenth of a cubic millimetre."""
_SAME_M = 1e-7
"""Distance below which two vertices are one: files often repeat a vertex for each face."""
_DETAILS_M = (1e-4, 2e-4, 4e-4, 8e-4, 1.6e-3)
"""Sizes of details that are removed, one after the other, while a solid has too many faces to be cut in seconds."""
_MANY_FACES = 3_000
_THINNEST_M = 1e-5
"""Ratio of volume to surface below which a piece is a remnant of a cut."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of a solid, and its convex hull; both are solids of manifold3d.

    Attributes:
        volume_m3: of the part itself.
        hull: the convex hull.
    """

    volume_m3: float
    hull: Any


def solid_of(mesh: Mesh) -> Any | None:
    """Make a solid from a mesh; None if the mesh is not closed. A mesh that is turned inside out is turned back."""
    vertices, faces = _merged(mesh)
    solid = _solid(vertices, faces)
    if solid is not None and solid.volume() < 0.0:
        solid = _solid(vertices, faces[:, ::-1])
    if solid is None or solid.volume() < LEAST_M3:
        return None
    for detail in _DETAILS_M:
        if solid.num_tri() > _MANY_FACES:
            solid = solid.simplify(detail)
    return solid


def mesh_of(solid: Any) -> Mesh:
    """Return a solid's surface as a mesh."""
    surface = solid.to_mesh64()
    vertices = np.array(surface.vert_properties, dtype=np.float64)[:, :3]
    return Mesh(vertices, np.array(surface.tri_verts, dtype=np.int32))


def hull_of_points(points: Floats) -> Any:
    """Make the convex hull of points (n, 3)."""
    return manifold3d.Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64))


def joint_hull(first: Any, second: Any) -> Any:
    """Make the convex hull of two solids together."""
    return manifold3d.Manifold.batch_hull([first, second])


def bounds_of(solid: Any) -> Floats:
    """Return the smallest and the largest x, y, z of a solid, (2, 3), metres."""
    bounds: Floats = np.array(solid.bounding_box(), dtype=np.float64).reshape(2, 3)
    return bounds


def parts_of(solid: Any) -> list[Any]:
    """Return the connected parts of a solid that have volume."""
    return [part for part in solid.decompose() if has_volume(part)]


def has_volume(solid: Any) -> bool:
    """True if a solid is more than a remnant of a cut."""
    volume = solid.volume()
    return bool(volume >= LEAST_M3 and volume >= _THINNEST_M * solid.surface_area())


def facets_of(hull: Any) -> tuple[Floats, Floats]:
    """Return the outward unit normals (f, 3) of a convex solid's faces, and their distances from the origin (f,)."""
    mesh = mesh_of(hull)
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    faces = lengths > 1e-14
    normals = normals[faces] / lengths[faces, None]
    return normals, np.einsum("fx,fx->f", normals, corners[faces, 0])


def _solid(vertices: Floats, faces: NDArray[np.int64]) -> Any | None:
    """Make a solid; None where the faces do not enclose one."""
    if not len(faces):
        return None
    surface = manifold3d.Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.uint64))
    solid = manifold3d.Manifold(surface)
    return solid if solid.status() == manifold3d.Error.NoError else None


def _merged(mesh: Mesh) -> tuple[Floats, NDArray[np.int64]]:
    """Merge equal vertices, and drop faces without an area."""
    _, first, index = np.unique(np.round(mesh.vertices / _SAME_M), axis=0, return_index=True, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces].astype(np.int64)
    a, b, c = faces.T
    return mesh.vertices[first], faces[(a != b) & (b != c) & (c != a)]
