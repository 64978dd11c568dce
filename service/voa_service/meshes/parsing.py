"""The mesh types that this service reads."""

from collections.abc import Callable
from importlib import import_module

from voa_service.meshes.triangles import Triangles

MESH_TYPES = ("obj", "stl", "ply", "glb")


def parser(mesh_type: str) -> Callable[[bytes], Triangles]:
    """Return what reads a file of a type; it raises `triangles.Unreadable` and nothing else.

    Only this type's module is imported: every upload pays for what its process imports.
    """
    module = import_module(f"voa_service.meshes.{MESH_TYPES[MESH_TYPES.index(mesh_type)]}")
    read: Callable[[bytes], Triangles] = getattr(module, f"read_{mesh_type}")
    return read
