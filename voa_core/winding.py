"""Orientation of faces: repair of meshes of which some faces are turned inside out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.objects import Object

Signs = NDArray[np.float64]

_MOST_BODIES = 256  # of different orientation; a larger number would need too many comparisons of pairs


def outward_faces(object_: Object) -> NDArray[np.int32] | None:
    """Turn flipped faces round, so that every face is counter-clockwise seen from outside the material.

    Faces that share edges are one body, and all faces of a body are made to agree. A body inside another keeps the
    orientation that it has in the file relative to the outermost body around it: a cavity remains a cavity.

    Args:
        object_: a mesh of one body or several.

    Returns:
        Faces (f, 3), or None if no turning helps: the mesh is not watertight, has only one side (like a Klein bottle),
        or consists of too many bodies.
    """
    if not object_.watertight:
        return None
    turned = _agreeing(object_)
    if turned is None:
        return None
    signs, body_of = turned
    corners = object_.vertices[object_.faces] - object_.vertices.mean(axis=0)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volumes = np.bincount(body_of, weights=signs * np.einsum("fi,fi->f", corners[:, 0], normals))
    signs *= np.where(volumes < 0.0, -1.0, 1.0)[body_of]
    agreeing = np.bincount(body_of, weights=signs * np.linalg.norm(normals, axis=1))
    senses = np.where(agreeing < 0.0, -1.0, 1.0)  # in the file: outwards, or inwards
    if senses.min() != senses.max():
        if len(senses) > _MOST_BODIES:
            return None
        signs *= (senses * senses[_outermost(corners, body_of, np.abs(volumes))])[body_of]
    faces: NDArray[np.int32] = np.where((signs < 0.0)[:, None], object_.faces[:, ::-1], object_.faces)
    return faces


def _agreeing(object_: Object) -> tuple[Signs, NDArray[np.intp]] | None:
    """Sign of each face, -1 if it must be turned to agree with its neighbours, and its body; None if they cannot agree.

    Every face stands twice in a graph, as it is and turned; two that share an edge are connected in the two ways in
    which they agree. A body with two sides falls into two parts, each of which has every face once.
    """
    from scipy.sparse import coo_array  # noqa: PLC0415 - slow to import, and needed for this alone
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    count = len(object_.faces)
    _, edges = object_.edges
    upwards = (object_.faces < np.roll(object_.faces, -1, axis=1)).reshape(-1)
    sides = np.argsort(edges.reshape(-1), kind="stable").reshape(-1, 2)
    one, other = sides[:, 0] // 3, sides[:, 1] // 3
    clash = upwards[sides[:, 0]] == upwards[sides[:, 1]]
    start, end = np.concatenate([one, one + count]), np.concatenate([other, other + count])
    end = np.where(np.tile(clash, 2), (end + count) % (2 * count), end)
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(2 * count, 2 * count))
    _, part = connected_components(graph, directed=False)
    as_is, turned = part[:count], part[count:]
    if (as_is == turned).any():
        return None
    body_of = np.unique(np.minimum(as_is, turned), return_inverse=True)[1].reshape(-1)
    return np.where(as_is < turned, 1.0, -1.0), body_of


def _outermost(corners: Floats, body_of: NDArray[np.intp], volumes: Floats) -> NDArray[np.intp]:
    """Find the largest body that encloses each body, (b,); itself if no other does."""
    count = len(volumes)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, body_of, corners.min(axis=1))
    np.maximum.at(high, body_of, corners.max(axis=1))
    around = np.arange(count)
    for body in range(count):
        boxed = (low <= low[body]).all(axis=1) & (high >= high[body]).all(axis=1) & (volumes > volumes[body])
        point = corners[np.argmax(body_of == body), 0]
        candidates = sorted(np.flatnonzero(boxed), key=lambda each: -volumes[each])
        around[body] = next((each for each in candidates if _encloses(corners[body_of == each], point)), body)
    return around


def _encloses(corners: Floats, point: Floats) -> bool:
    """True if a point lies within a closed surface of triangles (f, 3, 3): then an odd number lies above it.

    "Above" is a tilted direction, in which no edge of a mesh made on a grid lies exactly over the point.
    """
    up = np.array([0.3141592653589793, 0.2718281828459045, 0.9096])
    up /= np.linalg.norm(up)
    side = np.cross(up, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    a, b, c = np.moveaxis((corners - point) @ np.stack([side, np.cross(up, side), up], axis=1), 1, 0)
    over = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    total = over[0] + over[1] + over[2]
    within = np.all([part > 0.0 for part in over], axis=0) | np.all([part < 0.0 for part in over], axis=0)
    height = sum(part * corner[:, 2] for part, corner in zip(over, (a, b, c), strict=True))
    return bool(np.count_nonzero(within & (height * total > 0.0)) % 2)
