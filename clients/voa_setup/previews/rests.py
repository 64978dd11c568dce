"""Preview of the rests of a mesh."""

from collections.abc import Sequence
from pathlib import Path

from voa_fleet.world.meshes import Mesh
from voa_msgs.objects import StablePose
from voa_setup.look.shading import shade
from voa_setup.look.views import front_view
from voa_setup.mesh import SetupMesh
from voa_setup.poses import LEAST_PROBABILITY
from voa_setup.previews.messages import RestPreview, RestsPreview
from voa_setup.previews.turntable import draw_turntable, png_of
from voa_setup.rests import NamedRest, name_rests
from voa_setup.symmetry import symmetry_of

_MOST_PICTURES = 24
_SIDE_PIXELS = 200


def preview_rests(mesh: SetupMesh, stable: Sequence[StablePose], folder: Path) -> RestsPreview:
    """List the rests of a mesh, and draw each as it turns into a file `rest-N.png` in a folder.

    Args:
        mesh: in metres.
        stable: its stable poses.
        folder: for the pictures; it exists.
    """
    named = name_rests(stable, symmetry_of(mesh.object_), ball=mesh.is_ball)
    x, y, z = mesh.extents.tolist()
    return RestsPreview(
        size_m=(x, y, z),
        watertight=mesh.watertight,
        notes=list(mesh.notes),
        rests=[_preview(mesh, rest, number, folder) for number, rest in enumerate(named)],
    )


def _preview(mesh: SetupMesh, rest: NamedRest, number: int, folder: Path) -> RestPreview:
    """Describe a rest; the first 24 are drawn."""
    is_drawn = number < _MOST_PICTURES
    picture, side = f"rest-{number}.png", f"side-{number}.png"
    edges = (0.0, 0.0, 0.0, 0.0)
    if is_drawn:
        corners = mesh.mesh.vertices @ rest.transform[:3, :3].T + rest.transform[:3, 3]
        placed = Mesh(corners, mesh.mesh.faces)
        (folder / picture).write_bytes(draw_turntable(placed))
        drawn = shade(placed, front_view(), _SIDE_PIXELS)
        (folder / side).write_bytes(png_of(drawn.pixels))
        edges = drawn.extent
    return RestPreview(
        name=rest.name,
        probability=rest.probability,
        likely=rest.probability >= LEAST_PROBABILITY,
        alike=len(rest.ups),
        picture=picture if is_drawn else None,
        side=side if is_drawn else None,
        side_m=edges,
    )
