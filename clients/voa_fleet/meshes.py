"""Triangle meshes from Wavefront OBJ files: all that the objects of this project need."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from voa_fleet.errors import InvalidObject
from voa_fleet.frames import Floats


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
    """Read the vertices and faces of an OBJ file; polygons become fans of triangles.

    Raises:
        InvalidObject: there is no such file, or it holds no mesh.
    """
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    try:
        for line in file.read_text(encoding="utf-8").splitlines():
            kind, *rest = line.split() or [""]
            if kind == "v":
                vertices.append([float(number) for number in rest[:3]])
            elif kind == "f":
                corners = [_index(corner, len(vertices)) for corner in rest]
                faces += [[corners[0], b, c] for b, c in pairwise(corners[1:])]
        mesh = Mesh(np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int32))
    except (OSError, ValueError, IndexError) as error:
        raise InvalidObject(f"{file} is not an OBJ file: {error}") from error
    shapes = mesh.vertices.shape[1:], mesh.faces.shape[1:]
    if shapes != ((3,), (3,)) or mesh.faces.max() >= len(mesh.vertices) or mesh.faces.min() < 0:
        raise InvalidObject(f"{file} holds no mesh: {len(vertices)} vertices, {len(faces)} faces")
    return mesh


def _index(corner: str, known: int) -> int:
    """The index, from 0, of a face's corner such as "7", "7/1/3" or "-1"."""
    number = int(corner.partition("/")[0])
    return number - 1 if number > 0 else known + number
