"""Warnings about a mesh that can be used, but whose scale or up axis is probably wrong."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from voa_meshes import LARGE_M, SMALL_M, UpAxis, unit_hint
from voa_msgs.warnings import ProbableMistake

_ON_THE_TABLE = 1e-6  # of the object's size


def extent_mistakes(extents: Sequence[float], scale: float | None = None) -> list[ProbableMistake]:
    """Warn of an object that is too small or too large for most arms, and name the scales to try.

    Args:
        extents: sides of the object's bounding box, metres.
        scale: metres per unit of the object's file, as it was applied; None: unknown, and guessed: 1 for an object that
            is too large, 0.001 for one that is too small.
    """
    size = float(max(extents))
    if SMALL_M <= size <= LARGE_M:
        return []
    hint = unit_hint(size, scale or (1.0 if size > LARGE_M else 0.001))
    usual = f"objects for an arm measure {1e3 * SMALL_M:g} mm to {LARGE_M:g} m"
    return [ProbableMistake(kind="extent", detail=f"the object measures {size:g} m, {usual}: {hint}")]


def up_mistakes(vertices: NDArray[np.float64], applied: UpAxis) -> list[ProbableMistake]:
    """Warn of a mesh that would stand on the table if the other axis of its file were up.

    Args:
        vertices: (v, 3) of the mesh, after the axis `applied` of the file became z.
        applied: the axis of the file that was taken as up.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    near = _ON_THE_TABLE * float((high - low).max())
    floor = low[1] if applied == "+Z" else -high[1]
    across = [0, 2]
    if abs(floor) > near or (low[across] > -near).any() or (high[across] < near).any():
        return []
    other = "+Y" if applied == "+Z" else "+Z"
    detail = (
        f"the mesh was read with {applied} up, and it stands on its file's plane {other[1].lower()} = 0, "
        f"around that axis: upload it with up={other} if {other} is up in the file, with up={applied} if not (in a "
        f'scenario file, "up" stands beside "object")'
    )
    return [ProbableMistake(kind="up-axis", detail=detail)]
