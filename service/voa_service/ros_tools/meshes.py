"""Meshes for ROS tools: bounding boxes, and triangles few enough for markers."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from voa_ros.outputs.beliefs import Bounds
from voa_scene.shapes import Vector

_HEADER_BYTES = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def corners_of(stl: bytes) -> NDArray[np.float32]:
    """Read the corners of the triangles of a binary STL file: shape (3 x triangles, 3), metres."""
    records = np.frombuffer(stl, _RECORD, offset=_HEADER_BYTES)
    return np.asarray(records["corners"], dtype=np.float32).reshape(-1, 3)


def bounds_of(stl: bytes) -> Bounds:
    """Compute the bounding box of a binary STL file."""
    corners = corners_of(stl)
    return Bounds(_vector(corners.min(axis=0)), _vector(corners.max(axis=0)))


def vectors_of(stl: bytes) -> Sequence[Vector]:
    """Return the corners of the triangles of a binary STL file, three for each triangle, metres."""
    return [_vector(corner) for corner in corners_of(stl)]


def _vector(values: NDArray[np.float32]) -> Vector:
    x, y, z = (round(float(value), 6) for value in values)
    return (x, y, z)
