"""What the makers of meshes share: an order that depends on the shape alone, and the text of an OBJ file."""

import numpy as np
from numpy.typing import NDArray

DECIMALS = 7
"""Of a metre: far below anything that matters, and above the single precision that manifold3d computes with."""

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (v, 3) in metres and faces (f, 3), counter-clockwise seen from outside."""


def canonical(points: NDArray[np.float64], corners: NDArray[np.integer]) -> Mesh:
    """Rounded vertices without repetitions, and faces, in an order that depends on the shape alone."""
    rounded = np.round(np.asarray(points, dtype=np.float64), DECIMALS) + 0.0  # no negative zeros
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    faces = index.reshape(-1)[np.asarray(corners)]
    first = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return vertices, turned[np.lexsort(turned.T[::-1])].astype(np.int64)


def obj_text(name: str, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> str:
    """The text of a Wavefront OBJ file, in metres."""
    lines = [f"# {name}, metres; made by make_{name}.py"]
    lines += [f"v {x:.{DECIMALS}f} {y:.{DECIMALS}f} {z:.{DECIMALS}f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines) + "\n"
