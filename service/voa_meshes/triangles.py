"""Triangles, which every reader of this package returns, and the error of a file that is refused."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class UnreadableMesh(Exception):
    """A mesh file that is refused; the text is one line that names the mistake and its place in the file."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of a mesh file, in its own unit and axes.

    Attributes:
        vertices: (v, 3) float64; vertices that no face uses may be infinite or not a number.
        faces: (f, 3) int64, indices of vertices, counter-clockwise seen from outside.
    """

    vertices: Floats
    faces: Indices
