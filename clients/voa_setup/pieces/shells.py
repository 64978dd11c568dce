"""Pieces of a surface that encloses no volume: a shell of even thickness, cut by a grid of cells."""

import numpy as np

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_setup.pieces.solids import Piece, has_volume, hull_of_points

THICKNESS_M = 0.001
"""Thickness of the shell, half of it to each side of the surface."""
_CELLS = 12.0
"""Number of cells along the longest side of the surface, at first."""
_SMALLEST_M = 0.004
_GROWTH = 1.5


def shell_pieces(mesh: Mesh, most: int) -> list[Piece]:
    """Thicken a surface, and make a convex piece of what lies in each cell and faces along the same axis.

    Args:
        mesh: that is not closed.
        most: largest number of pieces; the cells grow until there are no more.
    """
    longest = float(np.ptp(mesh.vertices[mesh.faces].reshape(-1, 3), axis=0).max())
    cell = max(longest / _CELLS, _SMALLEST_M)
    pieces = _cells(mesh, cell)
    while len(pieces) > most and cell < longest:
        cell *= _GROWTH
        pieces = _cells(mesh, cell)
    return pieces


def _cells(mesh: Mesh, cell: float) -> list[Piece]:
    corners = _subdivided(mesh.vertices[mesh.faces], cell)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, normals = corners[lengths > 0.0], normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    prisms = np.concatenate([corners + side * THICKNESS_M / 2.0 * normals[:, None, :] for side in (1.0, -1.0)], axis=1)
    facing = np.abs(normals).argmax(axis=1)
    keys = np.column_stack([np.floor(corners.mean(axis=1) / cell).astype(np.int64), facing])
    _, groups = np.unique(keys, axis=0, return_inverse=True)
    groups = groups.reshape(-1)
    hulls = [hull_of_points(prisms[groups == group].reshape(-1, 3)) for group in range(int(groups.max(initial=-1)) + 1)]
    return [Piece(hull.volume(), hull) for hull in hulls if has_volume(hull)]


def _subdivided(corners: Floats, longest_m: float) -> Floats:
    """Halve triangles (t, 3, 3) at their longest edge until no edge is longer than `longest_m`."""
    done = []
    while len(corners):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        small = edges.max(axis=1) <= longest_m
        done.append(corners[small])
        large, first = corners[~small], edges[~small].argmax(axis=1)
        # Turned so that the longest edge is the first one.
        large = np.take_along_axis(large, ((first[:, None] + np.arange(3)) % 3)[:, :, None], axis=1)
        middle = large[:, :2].mean(axis=1)
        a, b, c = large[:, 0], large[:, 1], large[:, 2]
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)
