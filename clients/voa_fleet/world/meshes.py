"""Triangle meshes from Wavefront OBJ files, the only format of this project's objects."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from voa_fleet.errors import InvalidObject
from voa_fleet.world.frames import Floats

LEAST_M3 = 1e-12
"""Volume below which a mesh is flat, a thousandth of a cubic millimetre."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh in metres.

    Attributes:
        vertices: (v, 3) float64.
        faces: (f, 3) int32, counter-clockwise seen from outside.
    """

    vertices: Floats
    faces: NDArray[np.int32]


def read_obj(file: Path) -> Mesh:
    """Read the vertices and faces of an OBJ file; convex polygons become fans of triangles.

    Raises:
        InvalidObject: there is no such file, it holds no mesh, or a polygon that is not convex.
    """
    vertices, groups = _read(file)
    return _checked(file, vertices, [polygon for polygons in groups for polygon in polygons])


def read_groups(file: Path) -> list[Mesh]:
    """Read an OBJ file as one mesh for each `o` or `g` group that has faces, in the file's order.

    Raises:
        InvalidObject: there is no such file, it holds no mesh, or a polygon that is not convex.
    """
    vertices, groups = _read(file)
    if not any(groups):
        _checked(file, vertices, [])
    return [_alone(_checked(file, vertices, polygons)) for polygons in groups if polygons]


def volume_of(mesh: Mesh) -> float:
    """Return the volume that a closed mesh encloses, cubic metres; negative where it is turned inside out."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] - mesh.vertices[0] for corner in range(3))
    return float(np.einsum("fx,fx->", a, np.cross(b, c)) / 6.0)


def encloses_volume(mesh: Mesh) -> bool:
    """True if a mesh has an inside: every edge is passed once in each direction, and the volume is above 0."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]).astype(np.int64)
    there = np.sort(edges[:, 0] * len(mesh.vertices) + edges[:, 1])
    back = np.sort(edges[:, 1] * len(mesh.vertices) + edges[:, 0])
    closed = bool((there == back).all() and (there[1:] != there[:-1]).all())
    return closed and volume_of(mesh) > LEAST_M3


def _read(file: Path) -> tuple[Floats, list[list[list[int]]]]:
    """Read all vertices (v, 3) of a file, and the polygons of each group."""
    vertices: list[list[float]] = []
    groups: list[list[list[int]]] = [[]]
    try:
        for line in file.read_text(encoding="utf-8").splitlines():
            kind, *rest = line.split() or [""]
            if kind == "v":
                vertices.append([float(number) for number in rest[:3]])
            elif kind == "f":
                groups[-1].append([_index(corner, len(vertices)) for corner in rest])
            elif kind in {"o", "g"}:
                groups.append([])
        return np.array(vertices, dtype=np.float64), groups
    except (OSError, ValueError, IndexError) as error:
        raise InvalidObject(f"{file} is not an OBJ file: {error}") from error


def _checked(file: Path, vertices: Floats, polygons: list[list[int]]) -> Mesh:
    """Make a mesh of a file's polygons; raises InvalidObject."""
    triangles = [[polygon[0], b, c] for polygon in polygons for b, c in pairwise(polygon[1:])]
    faces = np.array(triangles, dtype=np.int32)
    shapes = vertices.shape[1:], faces.shape[1:]
    if shapes != ((3,), (3,)) or faces.max() >= len(vertices) or faces.min() < 0:
        raise InvalidObject(f"{file} holds no mesh: {len(vertices)} vertices, {len(triangles)} faces")
    if not all(_is_convex(vertices[polygon]) for polygon in polygons if len(polygon) > 3):
        raise InvalidObject(f"{file} has polygons that are not convex: export it with triangles")
    return Mesh(vertices, faces)


def _alone(mesh: Mesh) -> Mesh:
    """Leave out the vertices that no face uses."""
    used, faces = np.unique(mesh.faces, return_inverse=True)
    return Mesh(mesh.vertices[used], faces.reshape(-1, 3).astype(np.int32))


def _is_convex(corners: Floats) -> bool:
    """True if all corners of a polygon (n, 3) turn in the same direction."""
    back, ahead = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turns = np.cross(back, ahead)
    whole = np.cross(corners[1:-1] - corners[0], corners[2:] - corners[0]).sum(axis=0)
    return bool((turns @ whole >= 0.0).all())


def _index(corner: str, known: int) -> int:
    """Index, from 0, of a face's corner such as "7", "7/1/3" or "-1"; raises ValueError for 0."""
    number = int(corner.partition("/")[0])
    if number == 0:
        raise ValueError("OBJ has no index 0")
    return number - 1 if number > 0 else known + number
