"""Thinner copies of meshes for pictures, by clustering vertices (Rossignac and Borrel, 1993)."""

import numpy as np

from voa_meshes.triangles import Floats, Indices

_ROUNDS = 12
_FINEST = 2048


def thinned(vertices: Floats, faces: Indices, most_faces: int) -> tuple[Floats, Indices]:
    """Thin a mesh to at most so many triangles; a mesh that has no more is returned unchanged.

    The vertices in each cell of a cubic grid become their mean, and triangles that lose a corner thereby are dropped.
    The number of cells along the longest edge of the bounding box is found by bisection.
    The result is for pictures: it may have gaps and may not enclose a volume.

    Args:
        vertices: (v, 3).
        faces: (f, 3), indices of vertices.
        most_faces: bound on the triangles, at least 1.

    Returns:
        Vertices (w, 3) and faces (g, 3), where 0 < g <= `most_faces` unless every triangle lies in one cell.
    """
    if len(faces) <= most_faces:
        return vertices, faces
    low = vertices.min(axis=0)
    edge = float((vertices.max(axis=0) - low).max())
    coarse, fine = 1.0, float(_FINEST)
    best = _clustered(vertices, faces, low, edge, coarse)
    for _ in range(_ROUNDS):
        middle = (coarse * fine) ** 0.5
        tried = _clustered(vertices, faces, low, edge, middle)
        if len(tried[1]) <= most_faces:
            best, coarse = tried, middle
        else:
            fine = middle
    return best


def _clustered(vertices: Floats, faces: Indices, low: Floats, edge: float, cells: float) -> tuple[Floats, Indices]:
    """Cluster vertices in a grid of `cells` cells along the longest edge."""
    places = np.floor((vertices - low) * (cells / edge)).astype(np.int64)
    _, cell_of, sizes = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    means = np.zeros((len(sizes), 3))
    for axis in range(3):
        means[:, axis] = np.bincount(cell_of.ravel(), weights=vertices[:, axis]) / sizes
    corners = cell_of.ravel()[faces]
    whole = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 0] != corners[:, 2])
    return means, corners[whole].astype(faces.dtype)
