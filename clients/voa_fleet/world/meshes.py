"""Triangle meshes from Wavefront OBJ files, the only format of this project's objects."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from voa_fleet.errors import InvalidObject
from voa_fleet.world.frames import Floats


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
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    polygons: list[list[int]] = []
    try:
        for line in file.read_text(encoding="utf-8").splitlines():
            kind, *rest = line.split() or [""]
            if kind == "v":
                vertices.append([float(number) for number in rest[:3]])
            elif kind == "f":
                corners = [_index(corner, len(vertices)) for corner in rest]
                faces += [[corners[0], b, c] for b, c in pairwise(corners[1:])]
                polygons += [corners] if len(corners) > 3 else []
        mesh = Mesh(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int32))
    except (OSError, ValueError, IndexError) as error:
        raise InvalidObject(f"{file} is not an OBJ file: {error}") from error
    shapes = mesh.vertices.shape[1:], mesh.faces.shape[1:]
    if shapes != ((3,), (3,)) or mesh.faces.max() >= len(mesh.vertices) or mesh.faces.min() < 0:
        raise InvalidObject(f"{file} holds no mesh: {len(vertices)} vertices, {len(faces)} faces")
    if not all(_is_convex(mesh.vertices[polygon]) for polygon in polygons):
        raise InvalidObject(f"{file} has polygons that are not convex: export it with triangles")
    return mesh


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
