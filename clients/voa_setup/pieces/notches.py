"""Notches of a solid: edges at which its surface turns inwards, and how deep they lie below its convex hull.

A solid without a notch is convex; a cut through a notch removes it (B. Chazelle, "Convex partitions of polyhedra",
1984).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_setup.pieces.solids import facets_of, mesh_of

_FLAT_M = 1e-7
"""Height of a neighbouring face over an edge up to which the two count as one plane."""
_SHARES = np.linspace(0.0, 1.0, 5)
"""Places along an edge at which its depth is measured: a groove is open at its ends, and deep in its middle."""


@dataclass(frozen=True, eq=False)
class Notches:
    """Edges at which a solid's surface turns inwards.

    Attributes:
        start, end: of each edge, (e, 3), metres.
        normals: outward unit normals of its two faces, (e, 2, 3).
        depths: largest distance of each edge from the surface of the convex hull, (e,), metres.
    """

    start: Floats
    end: Floats
    normals: Floats
    depths: Floats

    @property
    def deepest_m(self) -> float:
        """Largest depth, metres; 0 without notches."""
        return float(self.depths.max(initial=0.0))


def notches_of(solid: Any, hull: Any) -> Notches:
    """Find the notches of a solid.

    Args:
        solid: of manifold3d.
        hull: its convex hull.
    """
    mesh = mesh_of(solid)
    edges, faces, opposite = _edges(mesh)
    normals, lengths = _normals(mesh)
    # Positive where the neighbour rises over the plane of the first face: the surface turns inwards.
    beyond = mesh.vertices[opposite] - mesh.vertices[edges[:, 0]]
    rise = np.einsum("ex,ex->e", beyond, normals[faces[:, 0]])
    inward = (rise > _FLAT_M) & (lengths[faces] > 0.0).all(axis=1)
    start, end = mesh.vertices[edges[inward, 0]], mesh.vertices[edges[inward, 1]]
    return Notches(start, end, normals[faces[inward]], _depths(start, end, hull))


def _edges(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Edges (e, 2) between two faces (e, 2), and the second face's corner (e,) that is not on the edge."""
    corners = mesh.faces.astype(np.int64)
    halves = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    face = np.tile(np.arange(len(corners)), 3)
    opposite = np.concatenate([corners[:, 2], corners[:, 0], corners[:, 1]])
    low, high = np.sort(halves, axis=1).T
    # In a closed surface every edge occurs twice: sorted, its two halves are neighbours.
    order = np.lexsort((high, low)).reshape(-1, 2)
    return halves[order[:, 0]], face[order], opposite[order[:, 1]]


def _normals(mesh: Mesh) -> tuple[Floats, Floats]:
    """Unit normals (f, 3) of the faces, and twice their areas (f,); 0 for a face without an area."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    lengths = np.where(lengths > 1e-13, lengths, 0.0)
    return normals / np.where(lengths > 0.0, lengths, 1.0)[:, None], lengths


def _depths(start: Floats, end: Floats, hull: Any) -> Floats:
    if not len(start):
        return np.zeros(0)
    normals, offsets = facets_of(hull)
    places = start[:, None, :] + _SHARES[None, :, None] * (end - start)[:, None, :]
    distances = (offsets - places.reshape(-1, 3) @ normals.T).min(axis=1)
    depths: Floats = distances.reshape(len(start), len(_SHARES)).max(axis=1)
    return depths
