"""Binary STL files of a mesh."""

import numpy as np

from voa_meshes.stl import HEADER, RECORD
from voa_meshes.triangles import Floats, Indices

_TITLE = b"triangles in metres, z up"


def write_stl(vertices: Floats, faces: Indices) -> bytes:
    """Write a binary STL file.

    Args:
        vertices: (v, 3).
        faces: (f, 3), indices of vertices.

    Returns:
        84 + 50 f bytes. Corners are float32; the normal of a triangle without an area is 0.
    """
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    records = np.zeros(len(faces), dtype=RECORD)
    records["corners"] = corners
    records["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    header = _TITLE.ljust(HEADER - 4, b"\0") + len(faces).to_bytes(4, "little")
    return header + records.tobytes()
