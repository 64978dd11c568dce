"""Strict readers of untrusted mesh files (OBJ, STL, PLY, GLB), and a writer of STL.

    triangles = read_mesh(content, "stl")
    vertices = turned_up(triangles.vertices, default_up("stl"))  # (v, 3), the file's unit, z up

A file is read as its format says or refused with `UnreadableMesh`; nothing is repaired, and nothing outside the file is
opened. The readers bound neither time nor memory: a service reads the files of others in a process with limits
(`voa_service.meshes`). Imports numpy and pydantic, nothing else of this project.

| name             | purpose                                                                      |
|------------------|------------------------------------------------------------------------------|
| `MESH_TYPES`     | the file types that can be read, as in the ending of a file's name           |
| `read_mesh`      | reads the triangles of a file                                                |
| `Triangles`      | vertices and faces of a file, in its own unit and axes                       |
| `write_stl`      | writes triangles as a binary STL file                                         |
| `thinned`        | thins a mesh for pictures                                                     |
| `UnreadableMesh` | the error of a file that is refused; its text says what is wrong and where   |
| `UpAxis`         | the axis of a file that points up, `default_up` of a type, `turned_up` to z  |
| `unit_hint`      | names the scales under which an object would be of a size that an arm grasps |
"""

from voa_meshes.axes import UpAxis, default_up, turned_up
from voa_meshes.reading import MESH_TYPES, read_mesh
from voa_meshes.stl_writing import write_stl
from voa_meshes.thinning import thinned
from voa_meshes.triangles import Triangles, UnreadableMesh
from voa_meshes.units import LARGE_M, SMALL_M, unit_hint

__all__ = [
    "LARGE_M",
    "MESH_TYPES",
    "SMALL_M",
    "Triangles",
    "UnreadableMesh",
    "UpAxis",
    "default_up",
    "read_mesh",
    "thinned",
    "turned_up",
    "unit_hint",
    "write_stl",
]
