"""Collision shapes of any mesh: convex pieces, and the file beside a scenario that holds them.

A physics engine collides convex shapes alone. The pieces are for the gripper; on the table the object rests on the
convex hull of its whole mesh, because no other part of it can touch a plane.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from voa_fleet.errors import InvalidObject
from voa_fleet.world.meshes import Mesh, read_groups
from voa_fleet.world.shapes import Hulls, MeshHull, Solid
from voa_setup.pieces.cutting import cut
from voa_setup.pieces.joining import join
from voa_setup.pieces.shells import THICKNESS_M, shell_pieces
from voa_setup.pieces.solids import mesh_of, solid_of

FILE = "hulls.obj"
"""Name of the file with the convex pieces, beside a scenario."""
DEEPEST_M = 0.0003
"""Depth of a notch that is left uncut."""
THICKEST_M = 0.00005
"""Average thickness of the space that joining two pieces may fill."""
MOST = 300
"""Largest number of pieces before neighbours are joined."""
_DECIMALS = 7


def convex_pieces(mesh: Mesh, *, deepest_m: float = DEEPEST_M, most: int = MOST) -> list[Mesh]:
    """Divide a mesh into convex pieces that together have nearly its shape.

    A closed mesh is cut at its notches (`voa_setup.pieces.cutting`). A mesh that is not closed has no inside: its
    surface becomes a shell 1 mm thick (`voa_setup.pieces.shells`). Equal meshes give equal pieces.

    Args:
        mesh: in metres.
        deepest_m: depth of a notch that is left uncut, metres.
        most: number of pieces at which the cutting ends.

    Raises:
        InvalidObject: the mesh has no faces with an area.
    """
    solid = solid_of(mesh)
    pieces = shell_pieces(mesh, most) if solid is None else cut(solid, deepest_m, most)
    pieces = join(pieces, THICKEST_M)
    if not pieces:
        raise InvalidObject("the mesh has no convex pieces: expected faces with an area, got none")
    meshes = [mesh_of(piece.hull) for piece in pieces]
    return sorted(meshes, key=lambda piece: tuple(np.round(piece.vertices.mean(axis=0), 6).tolist()))


def is_closed(mesh: Mesh) -> bool:
    """True if a mesh encloses a volume, so that it is cut into pieces and not made a shell."""
    return solid_of(mesh) is not None


def describe_pieces(mesh: Mesh, pieces: Sequence[Mesh]) -> str:
    """Describe in a clause, for a list of notes, what the simulation collides instead of a mesh."""
    count = f"{len(pieces)} convex piece{'' if len(pieces) == 1 else 's'}"
    if is_closed(mesh):
        return f"in the simulation the gripper meets {count} instead of the mesh"
    return (
        f"the mesh is not closed, so it has no inside: in the simulation the gripper meets a shell "
        f"{THICKNESS_M * 1e3:g} mm thick around its surface, of {count}"
    )


def collision_solids(file: str = FILE) -> list[Solid]:
    """Make the `solids` of physics.json for an object whose convex pieces are in `file`."""
    return [MeshHull(kind="hull", touches="table"), Hulls(kind="hulls", file=file, touches="gripper")]


def write_hulls(file: Path, pieces: Sequence[Mesh]) -> None:
    """Write convex pieces to an OBJ file, one `o` group each, in metres rounded to a tenth of a micrometre."""
    lines = ["# convex pieces of the mesh, which the simulation collides; metres"]
    before = 1
    for index, piece in enumerate(pieces):
        lines.append(f"o piece{index}")
        lines += [" ".join(["v", *(_number(value) for value in vertex)]) for vertex in piece.vertices.tolist()]
        lines += [f"f {a + before} {b + before} {c + before}" for a, b, c in piece.faces.tolist()]
        before += len(piece.vertices)
    file.write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\n")


def read_hulls(file: Path) -> list[Mesh]:
    """Read convex pieces from an OBJ file, one for each `o` or `g` group; raises InvalidObject."""
    return read_groups(file)


def _number(value: float) -> str:
    return f"{round(value, _DECIMALS) + 0.0:.{_DECIMALS}f}".rstrip("0").rstrip(".")
