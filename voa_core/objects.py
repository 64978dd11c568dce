"""The object to be grasped: a triangle mesh in metres."""

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from voa_core.checks import Floats, finite_array, float_array, frozen, number
from voa_core.errors import InvalidInput

_BOX_FACES = 16
_MORTON_BITS = 10


@dataclass(frozen=True, eq=False)
class Object:
    """A triangle mesh in metres, in its own frame; equal corners are one vertex.

    Attributes:
        vertices: (v, 3) float64, in metres.
        faces: (f, 3) int32, indices of vertices, counter-clockwise seen from outside.
    """

    vertices: Floats
    faces: NDArray[np.int32]

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, faces: ArrayLike, scale: float = 1.0) -> "Object":
        """Make an object from arrays of vertices (v, 3) and faces (f, 3); `scale` is their unit in metres.

        Vertices that no face uses are dropped, finite or not; so are faces of which two corners coincide.

        Raises:
            InvalidInput: there is no face, an index is out of range, or a number is not finite.
        """
        number("scale", scale, above=0.0)
        corners = np.asarray(faces)
        if corners.ndim != 2 or corners.shape[1:] != (3,) or corners.shape[0] == 0:
            raise InvalidInput("faces", "at least one triangle, shape nx3", f"shape {corners.shape}")
        if not np.issubdtype(corners.dtype, np.integer):
            raise InvalidInput("faces", "integers", str(corners.dtype))
        points = float_array("vertices", vertices, (None, 3))
        if corners.min() < 0 or corners.max() >= len(points):
            raise InvalidInput("faces", f"indices from 0 to {len(points) - 1}", f"{corners.min()} to {corners.max()}")
        used = np.zeros(len(points), dtype=bool)
        used[corners] = True
        points[~used] = 0.0
        with np.errstate(over="ignore"):
            scaled = finite_array("vertices", points, (None, 3)) * scale + 0.0  # -0 is 0
        merged, index = np.unique(finite_array("scale", scaled, (None, 3)), axis=0, return_inverse=True)
        return cls(*_compact(merged, index.reshape(-1)[corners]))

    @cached_property
    def digest(self) -> str:
        """Digest of the content: SHA-256 over vertices and faces, hexadecimal."""
        hasher = hashlib.sha256()
        for array in (self.vertices, self.faces):
            hasher.update(np.ascontiguousarray(array).tobytes())
        return hasher.hexdigest()

    @cached_property
    def extents(self) -> Floats:
        """Size of the bounding box in its own frame, (3,), metres."""
        corners = self.vertices[self.faces.reshape(-1)]
        return frozen(corners.max(axis=0) - corners.min(axis=0))

    @cached_property
    def edges(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Unique edges (e, 2), lower vertex first, and the three edges of each face (f, 3)."""
        sides = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        key = sides[:, 0].astype(np.int64) * len(self.vertices) + sides[:, 1]
        unique, index = np.unique(key, return_inverse=True)
        ends = np.stack(np.divmod(unique, len(self.vertices)), axis=1).astype(np.int32)
        return frozen(ends), frozen(index.reshape(-1, 3).astype(np.int32))

    @cached_property
    def boxes(self) -> tuple[NDArray[np.int32], Floats, Floats]:
        """Boxes, each around 16 faces that are neighbours in space: their faces, centres and half extents.

        Faces are indices (b, 16), -1 where the last box has fewer; centres and half extents are (3, b), metres.
        """
        corners = self.vertices[self.faces]
        low, high = corners.min(axis=1), corners.max(axis=1)
        order = np.argsort(_morton_codes(low + high), kind="stable")
        starts = np.arange(0, len(order), _BOX_FACES)
        low, high = np.minimum.reduceat(low[order], starts), np.maximum.reduceat(high[order], starts)
        boxed = np.full((len(starts), _BOX_FACES), -1, dtype=np.int32)
        boxed.reshape(-1)[: len(order)] = order
        return frozen(boxed), frozen(0.5 * (low + high).T.copy()), frozen(0.5 * (high - low).T.copy())

    @cached_property
    def boxed_faces(self) -> tuple[Floats, NDArray[np.int32]]:
        """Corners and edges of the faces in each of the `boxes`, in an order in which a loop over boxes reads them.

        Corners are (b, 3, 3, 16) metres, by corner, axis and face; edges are (b, 3, 16), by side and face, the first
        side between the first two corners, numbered so that edges of one box have near numbers. Where the last box
        has fewer faces, its last one is repeated.
        """
        boxed = self.boxes[0]
        filled = np.where(boxed >= 0, boxed, boxed.max(axis=1, keepdims=True))
        corners = self.vertices[self.faces[filled]].transpose(0, 2, 3, 1)
        edges = self.edges[1][filled].transpose(0, 2, 1)
        _, first, index = np.unique(edges, return_index=True, return_inverse=True)
        number = first.argsort().argsort().astype(np.int32)
        return frozen(corners.copy()), frozen(number[index.reshape(edges.shape)])

    @cached_property
    def watertight(self) -> bool:
        """True if every edge belongs to exactly two faces."""
        ends, of_face = self.edges
        return bool((np.bincount(of_face.reshape(-1), minlength=len(ends)) == 2).all())


def _compact(points: Floats, corners: NDArray[np.integer]) -> tuple[Floats, NDArray[np.int32]]:
    """Vertices and faces without the faces of which two corners coincide, and the vertices that are left over."""
    faces = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    if not len(faces):
        raise InvalidInput("faces", "at least one triangle with three corners", "corners that coincide")
    used = np.zeros(len(points), dtype=bool)
    used[faces] = True
    return frozen(points[used]), frozen((np.cumsum(used) - 1)[faces].astype(np.int32))


def _morton_codes(places: Floats) -> NDArray[np.int64]:
    """Position of points (k, 3) along Morton's curve, (k,): the bits of their grid cells, taken in turn."""
    low, size = places.min(axis=0), float(np.ptp(places, axis=0).max())
    cells = ((places - low) * ((2**_MORTON_BITS - 1) / size if size > 0.0 else 0.0)).astype(np.int64)
    codes = np.zeros(len(places), dtype=np.int64)
    for bit in range(_MORTON_BITS):
        for axis in range(3):
            codes |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return codes
