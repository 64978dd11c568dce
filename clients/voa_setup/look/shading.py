"""Pictures of meshes by a z-buffer: shaded faces, and dark lines where the surface folds or ends.

The time depends on the pixels that the faces cover, so that a mesh of 200 000 faces is drawn in less than a second.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_setup.look.views import View

_BASE = np.array([0.62, 0.69, 0.76])
_LINE = np.array([0.20, 0.24, 0.28])
_LIGHT = np.array([-0.35, 0.45, 0.82])
"""Direction of the light in the picture: right, up, toward the viewer."""
_FOLD = 0.75
"""Cosine of the angle between the normals of neighbouring pixels below which a line is drawn."""
_STEP = 0.02
"""Difference in depth of neighbouring pixels, as a share of the picture's size, from which a line is drawn."""
_BLOCK = 4_000_000
"""Most pixels that are worked on at once: it bounds the memory."""


@dataclass(frozen=True, eq=False)
class Shaded:
    """A shaded picture of a mesh, transparent where there is none.

    Attributes:
        pixels: (rows, columns, 4) red, green, blue and opacity, 0 to 1; the first row is the lowest.
        extent: left, right, bottom and top of the picture, metres.
    """

    pixels: Floats
    extent: tuple[float, float, float, float]


def shade(mesh: Mesh, view: View, pixels: int = 360) -> Shaded:
    """Draw a mesh in the world frame; the longer side of its bounding box is `pixels` long."""
    points = view.project(mesh.vertices)
    depths = mesh.vertices @ view.toward
    low, high = points.min(axis=0), points.max(axis=0)
    size = max(float((high - low).max()), 1e-9) / pixels
    columns, rows = (np.ceil((high - low) / size).astype(int) + 3).tolist()
    corner = low - 1.25 * size  # an edge of the object never runs through centres of pixels
    face_of_pixel, depth = _nearest_faces((points - corner) / size, depths / size, mesh.faces, rows, columns)
    visible, face_of_pixel = np.unique(face_of_pixel, return_inverse=True)
    normals = _normals(mesh, mesh.faces[visible], view) * (visible >= 0)[:, None]
    colours = _colours(normals[face_of_pixel.reshape(rows, columns)], depth, _STEP * pixels)
    right, top = corner + np.array([columns, rows]) * size
    return Shaded(colours, (float(corner[0]), float(right), float(corner[1]), float(top)))


def _normals(mesh: Mesh, faces: NDArray[np.int32], view: View) -> Floats:
    """Unit normals (f, 3) of faces in the picture's frame, turned toward the viewer."""
    corners = mesh.vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    seen = (normals / np.where(lengths > 0.0, lengths, 1.0)) @ np.column_stack([view.right, view.up, view.toward])
    turned: Floats = np.where(seen[:, 2:] < 0.0, -seen, seen)
    return turned


def _nearest_faces(
    points: Floats, depths: Floats, faces: NDArray[np.int32], rows: int, columns: int
) -> tuple[NDArray[np.int64], Floats]:
    """Face nearest to the viewer at each pixel, -1 for none, and its depth: (rows, columns) each.

    Args:
        points: (v, 2) vertices, in pixels from the lower left corner.
        depths: (v,) toward the viewer, in pixels.
        faces: (f, 3) vertices of each face.
        rows, columns: size of the picture.
    """
    nearest = np.full(rows * columns, -1, dtype=np.int64)
    depth = np.full(rows * columns, -np.inf)
    x, y = points[:, 0][faces], points[:, 1][faces]
    (left, right), (low, high) = _bounds(x), _bounds(y)
    # Faces between the centres of pixels, which are most of a fine mesh, cover none.
    covering = np.flatnonzero((_first(left) < _first(right)) & (_first(low) < _first(high)))
    area = np.maximum(right - left, 1.0) * np.maximum(high - low, 1.0)
    block = np.cumsum(area[covering]) // _BLOCK
    if not len(covering):
        return nearest.reshape(rows, columns), depth.reshape(rows, columns)
    for index in range(int(block[-1]) + 1):
        chosen = covering[block == index]
        face, pixel, at = _covered(x[chosen], y[chosen], depths[faces[chosen]], columns)
        # Of several faces at a pixel the nearest is written last; equals in the order of the faces.
        order = np.lexsort((face, at))
        face, pixel, at = chosen[face[order]], pixel[order], at[order]
        _, last = np.unique(pixel[::-1], return_index=True)
        last = len(pixel) - 1 - last
        nearer = at[last] > depth[pixel[last]]
        nearest[pixel[last[nearer]]], depth[pixel[last[nearer]]] = face[last[nearer]], at[last[nearer]]
    return nearest.reshape(rows, columns), depth.reshape(rows, columns)


def _bounds(values: Floats) -> tuple[Floats, Floats]:
    """Smallest and largest of the three values of each face (f, 3): (f,) each."""
    first, second, third = values.T
    return np.minimum(np.minimum(first, second), third), np.maximum(np.maximum(first, second), third)


def _covered(x: Floats, y: Floats, depths: Floats, columns: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Pixels whose centres faces cover: index of the face, index of the pixel, and depth, (k,) each.

    Args:
        x, y: corners of the faces, (f, 3), in pixels.
        depths: of the corners, (f, 3), in pixels.
        columns: of the picture.
    """
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    face, row = _runs(*map(_first, _bounds(y)))
    levels = row.astype(np.float64) + 0.5
    sides = [_crossing(x[face], y[face], levels, start, (start + 1) % 3) for start in range(3)]
    left, right = np.fmin.reduce(sides), np.fmax.reduce(sides)
    usable = np.isfinite(left) & (np.abs(area[face]) > 1e-12)
    face, row, left, right = face[usable], row[usable], left[usable], right[usable]
    line, column = _runs(_first(left), _first(right))
    face, row = face[line], row[line]
    across, along = column + 0.5 - x[face, 0], row + 0.5 - y[face, 0]
    first = (across * (y[face, 2] - y[face, 0]) - along * (x[face, 2] - x[face, 0])) / area[face]
    second = (along * (x[face, 1] - x[face, 0]) - across * (y[face, 1] - y[face, 0])) / area[face]
    base = depths[face, 0]
    at = base + first * (depths[face, 1] - base) + second * (depths[face, 2] - base)
    return face, row * columns + column, at


def _first(places: Floats) -> NDArray[np.int64]:
    """Indices (k,) of the first pixels whose centres lie at or beyond `places`, in pixels."""
    return np.ceil(places - 0.5).astype(np.int64)


def _runs(starts: NDArray[np.int64], ends: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """List each run's index with each of its members, from its start to below its end."""
    lengths = np.maximum(ends - starts, 0)
    index = np.repeat(np.arange(len(starts)), lengths)
    offset = np.arange(len(index)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    return index, starts[index] + offset


def _crossing(x: Floats, y: Floats, level: Floats, start: int, end: int) -> Floats:
    """Abscissae (k,) at which sides of triangles cross their levels; NaN where they do not.

    A side is always followed upwards, so that the two faces beside it agree to the last bit and leave no gap.
    """
    rises = y[:, start] <= y[:, end]
    low, high = np.where(rises, y[:, start], y[:, end]), np.where(rises, y[:, end], y[:, start])
    begin, finish = np.where(rises, x[:, start], x[:, end]), np.where(rises, x[:, end], x[:, start])
    crosses = (low <= level) != (high <= level)
    share = np.full(len(level), np.nan)
    np.divide(level - low, high - low, out=share, where=crosses)
    crossing: Floats = begin + share * (finish - begin)
    return crossing


def _colours(normals: Floats, depth: Floats, step: float) -> Floats:
    """Colour each pixel by the light on its face, with lines at folds and where the depth jumps.

    Args:
        normals: of the face at each pixel, (rows, columns, 3); zeros where there is none.
        depth: of each pixel toward the viewer, in pixels.
        step: difference in depth from which a line is drawn, in pixels.
    """
    covered = np.isfinite(depth)
    brightness = 0.55 + 0.5 * np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    colours = np.clip(brightness[..., None] * _BASE, 0.0, 1.0)
    colours[_lines(covered, normals, np.where(covered, depth, 0.0), step)] = _LINE
    return np.dstack([colours, covered.astype(np.float64)])


def _lines(covered: NDArray[np.bool_], normals: Floats, depth: Floats, step: float) -> NDArray[np.bool_]:
    """Flag the covered pixels beside an empty one, a fold, or a surface that lies farther back by `step` pixels."""
    flags = np.zeros_like(covered)
    for axis in (0, 1):
        for shift in (1, -1):
            other, normal = np.roll(covered, shift, axis), np.roll(normals, shift, axis)
            behind = depth - np.roll(depth, shift, axis)
            cosine = np.einsum("rci,rci->rc", normals, normal)
            # A slanted surface also falls back from pixel to pixel; that is no step.
            slant = 2.0 / np.maximum(normals[..., 2], 0.05)
            flags |= covered & (~other | (cosine < _FOLD) | (behind > step + slant))
    return flags
