"""Rests of a convex body: the faces on which it lies still, and from which faces it topples to each.

The height of the centre of mass over the table is a landscape over the directions that may point down. Its nodes are
the faces of the body, its valleys the edges: toppling over an edge follows the arc from one face's normal to the
other's. A rest is a node from which every arc rises. The way from any other face, and the
probability of landing on each face, are quasi-static (Goldberg et al., "Part pose statistics", IEEE Trans. Robotics and
Automation 15(5), 1999).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats

Indices = NDArray[np.intp]

_FLAT_RAD = 1e-6  # neighbouring triangles whose normals differ by less are one face
HOLDS_RAD = math.radians(9.0)
"""Tilt that a rest must withstand in every direction to be listed; a less stable one is merged into its neighbour."""
_ROUNDING = 1e-9  # of a height, in favour of a rest that topples at exactly that tilt


@dataclass(frozen=True)
class Body:
    """A convex polyhedron with its centre of mass at the origin.

    Attributes:
        points: (v, 3), in metres.
        triangles: (t, 3) indices of points.
        neighbours: (t, 3) indices of triangles: the one that shares the side opposite to each corner.
        normals: (t, 3) unit vectors that point outwards.
        distances: (t,) from the origin to the planes of the triangles, all above 0.
    """

    points: Floats
    triangles: Indices
    neighbours: Indices
    normals: Floats
    distances: Floats

    @cached_property
    def areas(self) -> Floats:
        """Areas of the triangles, (t,), in square metres."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        areas: Floats = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return areas

    @cached_property
    def solid_angles(self) -> Floats:
        """Share of all directions in which the origin sees each triangle, (t,).

        By van Oosterom and Strackee (IEEE Trans. Biomedical Engineering 30(2), 1983).
        """
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
        volume = np.abs(np.einsum("ti,ti->t", a, np.cross(b, c)))
        ab, bc, ca = (np.einsum("ti,ti->t", p, q) for p, q in ((a, b), (b, c), (c, a)))
        shares: Floats = np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb) / (2.0 * np.pi)
        return shares


@dataclass(frozen=True)
class Rest:
    """A rest of a body: an orientation in which it lies still.

    Attributes:
        down: unit vector (3,) in the body's frame that points to the table.
        height: of the centre of mass over the table, in metres.
        probability: that the body ends there when it is dropped in a random orientation.
    """

    down: Floats
    height: float
    probability: float


@dataclass(frozen=True)
class _Faces:
    """Triangles in one plane taken together: normals (f, 3), distances (f,), centroids (f, 3), solid angles (f,)."""

    normals: Floats
    distances: Floats
    centroids: Floats
    solid_angles: Floats


@dataclass(frozen=True)
class _Arcs:
    """The edges between faces, each in both directions.

    Attributes:
        start, end: (e,) indices of faces.
        inside: (e,) metres by which the centre of mass, dropped on the plane of `start`, lies inside the edge.
        leaving: (e,) share of the way from the centroid of `start` to the dropped centre of mass where it is crossed.
        passes: (e,) metres, the greatest height of the centre of mass while the body topples over the edge.
    """

    start: Indices
    end: Indices
    inside: Floats
    leaving: Floats
    passes: Floats


def rests(body: Body, holds_rad: float = HOLDS_RAD) -> list[Rest]:
    """List the rests of a body; a rest that does not hold is merged into the one that the body falls to.

    Args:
        body: the convex hull of an object, about its centre of mass.
        holds_rad: tilt that a listed rest withstands in its weakest direction.

    Returns:
        The rests, in no particular order; their probabilities sum to 1.
    """
    faces, face_of = _faces(body)
    arcs = _arcs(body, faces, face_of)
    ends_at = _ends_at(faces, arcs)
    merged = _merged(faces, arcs, ends_at, holds_rad)
    shares = np.bincount(merged[ends_at], weights=faces.solid_angles, minlength=len(merged))
    total = float(shares.sum())
    return [
        Rest(faces.normals[face], float(faces.distances[face]), float(shares[face]) / total)
        for face in np.unique(merged[ends_at])
    ]


def _faces(body: Body) -> tuple[_Faces, Indices]:
    """Join triangles in one plane to faces, each in the plane of its largest; also each triangle's face."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - slow to import, and needed for this alone
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    start = np.repeat(np.arange(len(body.triangles)), 3)
    end = body.neighbours.reshape(-1)
    flat = np.linalg.norm(body.normals[start] - body.normals[end], axis=1) < _FLAT_RAD
    shape = (len(body.triangles),) * 2
    level = coo_array((flat[flat], (start[flat], end[flat])), shape=shape)
    count, face_of = connected_components(level, directed=False)
    largest = np.zeros(count, dtype=np.intp)
    by_area = np.argsort(body.areas, kind="stable")
    largest[face_of[by_area]] = by_area  # the last one written stays
    weights = np.maximum(body.areas, np.finfo(np.float64).tiny)
    middles = body.points[body.triangles].mean(axis=1) * weights[:, None]
    area = np.bincount(face_of, weights=weights, minlength=count)
    centroids = np.stack([np.bincount(face_of, weights=axis, minlength=count) for axis in middles.T], axis=1)
    shares = np.bincount(face_of, weights=body.solid_angles, minlength=count).astype(np.float64)
    return _Faces(body.normals[largest], body.distances[largest], centroids / area[:, None], shares), face_of


def _arcs(body: Body, faces: _Faces, face_of: Indices) -> _Arcs:
    start = np.repeat(face_of, 3)
    end = face_of[body.neighbours].reshape(-1)
    between = start != end
    start, end = start[between], end[between]
    first = body.points[body.triangles[:, [1, 2, 0]].reshape(-1)[between]]
    last = body.points[body.triangles[:, [2, 0, 1]].reshape(-1)[between]]
    here, there = faces.normals[start], faces.normals[end]
    outwards = _across(here, there)
    inside = _dot(first, outwards)
    middle = _dot(first - faces.centroids[start], outwards)
    leaving = np.maximum(middle, 0.0) / np.where(inside < 0.0, np.maximum(middle, 0.0) - inside, 1.0)
    along = last - first
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    arms = np.linalg.norm(first - _dot(first, along)[:, None] * along, axis=1)
    over_the_edge = (inside > 0.0) & (_dot(first, _across(there, here)) > 0.0)
    passes = np.where(over_the_edge, arms, np.maximum(faces.distances[start], faces.distances[end]))
    return _Arcs(start, end, inside, leaving, passes)


def _ends_at(faces: _Faces, arcs: _Arcs) -> Indices:
    """Find the face on which the body lies still after it was put on each face, (f,).

    It topples over the edge that is crossed first on the way from the face's centroid to the point under the centre of
    mass. The centre of mass sinks each time; equal heights, known to rounding only, are ordered by index, so that no
    round trip exists.
    """
    heights, count = faces.distances, len(faces.distances)
    sinks = (heights[arcs.end] < heights[arcs.start]) | (
        (heights[arcs.end] == heights[arcs.start]) & (arcs.end < arcs.start)
    )
    falls = np.flatnonzero((arcs.inside < 0.0) & sinks)
    falls = falls[np.argsort(-arcs.leaving[falls], kind="stable")]
    to: Indices = np.arange(count)
    to[arcs.start[falls]] = arcs.end[falls]  # the last one written stays
    while (to[to] != to).any():
        to = to[to]
    return to


def _merged(faces: _Faces, arcs: _Arcs, ends_at: Indices, holds_rad: float) -> Indices:
    """Find the rest into which each rest is merged, (f,); itself for one that holds.

    From the lowest pass upwards, the shallower of the two basins that meet there joins the deeper if it does not hold.
    Over one edge a body whose centre of mass lies at height h topples at the tilt t with cos t = h / height of the
    pass; the same formula is used where it rolls over several edges, so that the facets of a curved wall are one rest.
    """
    a, b = ends_at[arcs.start], ends_at[arcs.end]
    too_high = (1.0 + _ROUNDING) * math.cos(holds_rad) * arcs.passes
    # Basins only get deeper as they grow: a rest that holds alone holds as a part of a larger basin.
    near = np.flatnonzero((a < b) & (np.maximum(faces.distances[a], faces.distances[b]) > too_high))
    near = near[np.argsort(arcs.passes[near], kind="stable")]
    into, heights = list(range(len(ends_at))), faces.distances.tolist()

    def bottom(face: int) -> int:
        while into[face] != face:
            into[face] = into[into[face]]
            face = into[face]
        return face

    for one, other, limit in zip(a[near].tolist(), b[near].tolist(), too_high[near].tolist(), strict=True):
        deep, shallow = sorted((bottom(one), bottom(other)), key=lambda face: (heights[face], face))
        if heights[shallow] > limit:
            into[shallow] = deep
    return np.array([bottom(face) for face in range(len(into))])


def _across(normals: Floats, others: Floats) -> Floats:
    """Unit vectors in the planes of `normals` that point over the edges to the faces of `others`, (e, 3)."""
    across: Floats = others - _dot(others, normals)[:, None] * normals
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    across /= np.maximum(lengths, np.finfo(np.float64).tiny)
    return across


def _dot(a: Floats, b: Floats) -> Floats:
    dot: Floats = np.einsum("ei,ei->e", a, b)
    return dot
