"""The mesh types that this service reads."""

from collections.abc import Callable
from importlib import import_module

import numpy as np

from voa_meshes.triangles import Triangles

MESH_TYPES = ("obj", "stl", "ply", "glb")


def parse(mesh_type: str, content: bytes) -> Triangles:
    """Read a file of one of `MESH_TYPES`; only its module is imported, for every upload pays for what it imports.

    Numbers that are not finite are read as they are: the next step knows whether a face uses them.

    Raises:
        Unreadable: the file cannot be read as it is meant.
    """
    module = import_module(f"voa_meshes.{mesh_type}")
    read: Callable[[bytes], Triangles] = getattr(module, f"read_{mesh_type}")
    with np.errstate(all="ignore"):
        return read(content)
