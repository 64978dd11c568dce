"""Triangles, which every reader of this package returns, and the error of a file that cannot be read as it is meant."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Unreadable(Exception):
    """A mesh file that is refused; the text is one line that names what is wrong and where."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of a mesh file, in its own unit and axes.

    Attributes:
        vertices: (v, 3) float64; those that no face uses may be anything.
        faces: (f, 3) int64, indices of vertices, counter-clockwise seen from outside.
    """

    vertices: Floats
    faces: Indices
