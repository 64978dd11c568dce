"""The axis of a mesh file that points up, and the rotation that makes it z."""

from typing import Literal

from voa_meshes.triangles import Floats

UpAxis = Literal["+Y", "+Z"]
"""The axis of a mesh file that points up."""


def default_up(mesh_type: str) -> UpAxis:
    """Return the axis that points up in files of a type: +Y in glTF, as its standard says, else +Z."""
    return "+Y" if mesh_type == "glb" else "+Z"


def turned_up(vertices: Floats, up: UpAxis) -> Floats:
    """Rotate vertices (v, 3) so that the axis that points up in the file becomes z; the unit stays the file's."""
    return vertices if up == "+Z" else vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
