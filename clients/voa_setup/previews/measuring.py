"""Measure a mesh file before its unit is known."""

from pathlib import Path

import numpy as np

from voa_msgs.objects import UpAxis
from voa_setup.mesh import LARGEST_M, SMALLEST_M, likely_scales, read_triangles
from voa_setup.previews.messages import MeshMeasure


def measure_mesh(file: Path) -> MeshMeasure:
    """Measure a mesh file in its own unit, along its own axes.

    Raises:
        UnusableMesh: the file cannot be read, or has too many faces.
    """
    vertices, faces = read_triangles(file, "+Z")
    x, y, z = np.ptp(vertices[np.unique(faces)], axis=0).tolist()
    extent = max(x, y, z)
    likely = [1.0] if SMALLEST_M <= extent <= LARGEST_M else []
    up: UpAxis = "+Y" if file.suffix.lower() == ".glb" else "+Z"
    return MeshMeasure(
        name=file.stem, faces=len(faces), extents=(x, y, z), up=up, scales=[*likely, *likely_scales(extent)]
    )
