"""Make mug.obj: a cup with a wall, a floor and one handle, from the measures below.

    python make_mug.py [FILE]

Needs trimesh and manifold3d (the `dev` extra). The same versions give the same file, byte
for byte: vertices are rounded and sorted, faces start at their lowest vertex and are sorted.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from voa_assets.make_obj import Mesh, canonical, obj_text


@dataclass(frozen=True)
class Mug:
    """Measures of the mug, in metres, and how finely its round parts are cut up.

    It stands upright around the z axis on z = 0; the handle points along +x, at half the height, so that the mug
    upside down has its handle at the same height.

    Attributes:
        radius, height: of the outside.
        wall, floor: thicknesses.
        handle_reach: from the middle of the wall to the middle of the handle's outermost point.
        handle_half_height: from the handle's middle to where it enters the wall.
        handle_radius: of the handle's round cross-section; a gripper that opens 18 mm must get around it.
        sections: sides of the cup's polygon.
        handle_steps: pieces along the handle.
        handle_sides: sides of the handle's cross-section.
    """

    radius: float = 0.040
    height: float = 0.095
    wall: float = 0.004
    floor: float = 0.005
    handle_reach: float = 0.030
    handle_half_height: float = 0.030
    handle_radius: float = 0.0035
    sections: int = 64
    handle_steps: int = 16
    handle_sides: int = 16


def make(mug: Mug | None = None) -> Mesh:
    """Make vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    mug = mug or Mug()
    # The handle runs from wall to wall through the cup; what of it is inside the cup is cut away again.
    solid = trimesh.boolean.union([_cup(mug), _handle(mug)], engine="manifold")
    cup = trimesh.boolean.difference([solid, _cavity(mug)], engine="manifold")
    return canonical(cup.vertices, cup.faces)


def _cup(mug: Mug) -> trimesh.Trimesh:
    inside = mug.radius - mug.wall
    profile = [
        [0.0, 0.0],
        [mug.radius, 0.0],
        [mug.radius, mug.height],
        [inside, mug.height],
        [inside, mug.floor],
        [0.0, mug.floor],
    ]
    return trimesh.creation.revolve(np.array(profile), sections=mug.sections)


def _handle(mug: Mug) -> trimesh.Trimesh:
    """A tube around half an ellipse that begins and ends in the middle of the wall.

    Half a turn about the x axis at half the mug's height maps this polyhedron, diagonals of its faces included, on
    itself: so the mug upside down looks the same from outside, to the last beam.
    """
    along = np.linspace(-np.pi / 2.0, np.pi / 2.0, mug.handle_steps + 1)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, mug.handle_sides, endpoint=False)[None, :]
    outward = np.hypot(mug.handle_half_height * np.cos(along), mug.handle_reach * np.sin(along))
    normal_x = mug.handle_half_height * np.cos(along) / outward
    normal_z = mug.handle_reach * np.sin(along) / outward
    middle = mug.radius - mug.wall / 2.0
    rings = np.stack(
        [
            middle + mug.handle_reach * np.cos(along) + mug.handle_radius * np.cos(around) * normal_x,
            np.broadcast_to(mug.handle_radius * np.sin(around), (mug.handle_steps + 1, mug.handle_sides)),
            mug.height / 2.0 + mug.handle_half_height * np.sin(along) + mug.handle_radius * np.cos(around) * normal_z,
        ],
        axis=-1,
    )
    return trimesh.Trimesh(*_tube(rings), process=False)


def _tube(rings: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Make the vertices and faces of the closed tube through rings (k, s, 3) of corners, each end a fan."""
    count, sides = rings.shape[:2]
    corner = np.arange(count * sides).reshape(count, sides)
    beside = np.roll(corner, -1, axis=1)
    lower = np.stack([corner[:-1], beside[:-1], corner[1:]], axis=-1).reshape(-1, 3)
    upper = np.stack([beside[:-1], beside[1:], corner[1:]], axis=-1).reshape(-1, 3)
    fan = np.stack([np.zeros(sides - 2, dtype=int), np.arange(1, sides - 1), np.arange(2, sides)], axis=-1)
    return rings.reshape(-1, 3), np.concatenate([lower, upper, corner[0][fan][:, ::-1], corner[-1][fan]])


def _cavity(mug: Mug) -> trimesh.Trimesh:
    """Make the inside of the cup, higher than the cup, so that no face of it lies in the plane of the rim."""
    inside, top = mug.radius - mug.wall, 2.0 * mug.height
    profile = [[0.0, mug.floor], [inside, mug.floor], [inside, top], [0.0, top]]
    return trimesh.creation.revolve(np.array(profile), sections=mug.sections)


def to_obj(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> str:
    """Write a mesh in metres as the text of a Wavefront OBJ file."""
    return obj_text("mug", vertices, faces)


def main() -> None:
    """Write the file named on the command line, or mug.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("mug.obj")
    target.write_text(to_obj(*make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
