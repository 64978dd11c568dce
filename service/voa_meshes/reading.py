"""Reading a mesh file of any type that this package supports."""

from collections.abc import Callable
from importlib import import_module

import numpy as np

from voa_meshes.triangles import Triangles

MESH_TYPES = ("obj", "stl", "ply", "glb")
"""The file types that can be read, as in the ending of a file's name."""


def read_mesh(content: bytes, mesh_type: str) -> Triangles:
    """Read the triangles of a mesh file.

    Coordinates that are not finite are returned as they are, since the file's faces may not use them. Only the module
    of the type is imported, so that reading an STL file does not wait for the modules of glTF.

    Args:
        content: the whole file.
        mesh_type: one of `MESH_TYPES`.

    Returns:
        Vertices (v, 3) in the file's unit and axes, and faces (f, 3).

    Raises:
        UnreadableMesh: the file breaks the rules of its format, or uses a part of it that is not supported.
        ValueError: the type is not one of `MESH_TYPES`.
    """
    if mesh_type not in MESH_TYPES:
        raise ValueError(f"expected a mesh type of {', '.join(MESH_TYPES)}, got {mesh_type[:40]!r}")
    module = import_module(f"voa_meshes.{mesh_type}")
    read: Callable[[bytes], Triangles] = getattr(module, f"read_{mesh_type}")
    with np.errstate(all="ignore"):
        return read(content)
