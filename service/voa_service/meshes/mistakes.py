"""Probable mistakes in a mesh that can be used all the same."""

from collections.abc import Sequence

from voa_core.objects import Object
from voa_meshes.units import LARGE_M, SMALL_M, unit_hint
from voa_msgs.objects import UpAxis
from voa_msgs.warnings import ProbableMistake

_ON_THE_TABLE = 1e-6  # of the object's size


def extent_mistakes(extents: Sequence[float], scale: float | None = None) -> list[ProbableMistake]:
    """Warn of an object that is hardly one for an arm, and name the scales to try.

    Args:
        extents: of the object's bounding box, metres.
        scale: what was applied to its file. None: it is not known any more; then too large is most often a file in
            millimetres read at 1, too small a file in metres read at 0.001.
    """
    size = float(max(extents))
    if SMALL_M <= size <= LARGE_M:
        return []
    hint = unit_hint(size, scale or (1.0 if size > LARGE_M else 0.001))
    usual = f"objects for an arm measure {1e3 * SMALL_M:g} mm to {LARGE_M:g} m"
    return [ProbableMistake(kind="extent", detail=f"the object measures {size:g} m, {usual}: {hint}")]


def up_mistakes(mesh: Object, applied: UpAxis) -> list[ProbableMistake]:
    """Warn of a mesh that stands on the table about the other axis of its file than the one that was taken for up.

    Args:
        mesh: with z up, if `applied` is right.
        applied: the axis of the file that became z.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
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


def default_up(mesh_type: str) -> UpAxis:
    """Return the axis that is up in files of a type: glTF's standard says +Y, the others say nothing."""
    return "+Y" if mesh_type == "glb" else "+Z"
