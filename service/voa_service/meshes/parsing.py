"""The mesh types that this service reads."""

from collections.abc import Callable, Mapping

from voa_service.meshes.glb import read_glb
from voa_service.meshes.obj import read_obj
from voa_service.meshes.ply import read_ply
from voa_service.meshes.stl import read_stl
from voa_service.meshes.triangles import Triangles

PARSERS: Mapping[str, Callable[[bytes], Triangles]] = {
    "obj": read_obj,
    "stl": read_stl,
    "ply": read_ply,
    "glb": read_glb,
}
"""Reads a file of a type, by its ending; each raises `triangles.Unreadable` and nothing else."""
