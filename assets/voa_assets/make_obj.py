"""Functions of the programs that make meshes: a canonical order of vertices and faces, and OBJ text."""

import numpy as np
from numpy.typing import NDArray

DECIMALS = 7
"""Decimals of a metre to which vertices are rounded: 0.1 micrometres, more than the single precision of manifold3d."""

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices (v, 3) in metres and faces (f, 3), counter-clockwise seen from outside."""


def canonical(points: NDArray[np.float64], corners: NDArray[np.integer]) -> Mesh:
    """Round vertices, remove repetitions, and bring vertices and faces into an order that depends on shape alone."""
    rounded = np.round(np.asarray(points, dtype=np.float64), DECIMALS) + 0.0  # no negative zeros
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    faces = index.reshape(-1)[np.asarray(corners)]
    first = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return vertices, turned[np.lexsort(turned.T[::-1])].astype(np.int64)


def obj_text(name: str, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> str:
    """Write a mesh in metres as the text of a Wavefront OBJ file."""
    lines = [f"# {name}, metres; made by make_{name}.py"]
    lines += [f"v {x:.{DECIMALS}f} {y:.{DECIMALS}f} {z:.{DECIMALS}f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines) + "\n"
