"""Make mallet.obj: a block for a head and a round handle that sticks out of it, from the measures below.

    python make_mallet.py [FILE]

Needs trimesh and manifold3d (the `dev` extra). The same versions give the same file, byte for byte.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from voa_assets.make_obj import Mesh, canonical, obj_text


@dataclass(frozen=True)
class Mallet:
    """Measures of the mallet, in metres.

    The head is centred at the origin, its long side along y; the handle points along +x.

    Attributes:
        head: the head's size along x, y and z.
        handle_length: of what sticks out of the head.
        handle_radius: of its round cross-section.
        sections: sides of that cross-section's polygon.
    """

    head: tuple[float, float, float] = (0.040, 0.090, 0.040)
    handle_length: float = 0.120
    handle_radius: float = 0.007
    sections: int = 24


def make(mallet: Mallet | None = None) -> Mesh:
    """Make vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    mallet = mallet or Mallet()
    head = trimesh.creation.box(mallet.head)
    reach = mallet.head[0] / 2.0 + mallet.handle_length
    handle = trimesh.creation.cylinder(mallet.handle_radius, reach, sections=mallet.sections)
    # Turned by half a side, so that no edge of the handle lies in the plane of its axis; then z becomes x.
    half = np.pi / mallet.sections
    turn = np.array([[0.0, 0.0, 1.0], [np.sin(half), np.cos(half), 0.0], [-np.cos(half), np.sin(half), 0.0]])
    place = np.eye(4)
    place[:3, :3] = turn
    place[:3, 3] = [reach / 2.0, 0.0, 0.0]
    handle.apply_transform(place)
    solid = trimesh.boolean.union([head, handle], engine="manifold")
    return canonical(solid.vertices, solid.faces)


def main() -> None:
    """Write the file named on the command line, or mallet.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("mallet.obj")
    target.write_text(obj_text("mallet", *make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
