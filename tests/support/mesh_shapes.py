"""Meshes of simple shapes, for tests of what is made of any mesh."""

import numpy as np
import trimesh

from voa_fleet.world.meshes import Mesh


def mesh_from(shape: trimesh.Trimesh) -> Mesh:
    """A mesh with the shape's vertices and faces."""
    return Mesh(np.asarray(shape.vertices, dtype=np.float64), np.asarray(shape.faces, dtype=np.int32))


def box(*size: float) -> Mesh:
    """A box around the origin."""
    return mesh_from(trimesh.creation.box(size))


def angle(length: float = 0.10, thickness: float = 0.01) -> Mesh:
    """Two plates at a right angle: an L of one length to each side."""
    bars = [trimesh.creation.box([length, 0.04, thickness]), trimesh.creation.box([thickness, 0.04, length])]
    bars[1].apply_translation([(thickness - length) / 2.0, 0.0, (length - thickness) / 2.0])
    return mesh_from(trimesh.boolean.union(bars, engine="manifold"))


def bowl() -> Mesh:
    """A round bowl with a wall of 3 mm."""
    profile = [
        [0, 0],
        [0.03, 0],
        [0.05, 0.02],
        [0.06, 0.045],
        [0.057, 0.045],
        [0.047, 0.022],
        [0.028, 0.003],
        [0, 0.003],
    ]
    return mesh_from(trimesh.creation.revolve(np.array(profile), sections=24))


def open_box() -> Mesh:
    """A box without its top."""
    closed = box(0.06, 0.04, 0.10)
    top = closed.vertices[:, 2].max()
    faces = [face for face in closed.faces if (closed.vertices[face, 2] < top).any()]
    return Mesh(closed.vertices, np.array(faces, dtype=np.int32))


def sheet() -> Mesh:
    """A flat sheet without thickness."""
    corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.06, 0.0], [0.0, 0.06, 0.0]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32))


def soup(mesh: Mesh) -> Mesh:
    """A mesh with corners of its own for each face, as many files have them."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size, dtype=np.int32).reshape(-1, 3))
