"""Make block.obj: a cube with a recess in one side and a rib in it to hold on to, from the measures below.

    python make_block.py [FILE]

Needs trimesh and manifold3d (the `dev` extra). The same versions give the same file, byte for byte.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from voa_assets.make_obj import Mesh, canonical, obj_text

_BEYOND = 0.01
"""Length by which cut-away volumes reach out of the block, so that no two faces lie in one plane."""


@dataclass(frozen=True)
class Block:
    """Measures of the block, in metres.

    The block is centred at the origin. Its recess opens towards +x and towards +z, so it has a floor; upside down, that
    is a roof, and the recess can be reached from the side alone.

    Attributes:
        size: of the block along x, y and z.
        depth: of the recess along x.
        width: of the recess along y, the rib included.
        floor: thickness of what is left below the recess.
        rib: thickness of the rib along y; it ends flush with the block.
    """

    size: float = 0.080
    depth: float = 0.040
    width: float = 0.056
    floor: float = 0.016
    rib: float = 0.008


def make(block: Block | None = None) -> Mesh:
    """Make vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    b = block or Block()
    half = b.size / 2.0
    solid = trimesh.creation.box([b.size] * 3)
    for side in (1.0, -1.0):
        ys = sorted((side * b.rib / 2.0, side * b.width / 2.0))
        bounds = np.array(
            [[half - b.depth, ys[0], b.floor - half], [half + _BEYOND, ys[1], half + _BEYOND]], dtype=np.float64
        )
        solid = trimesh.boolean.difference([solid, trimesh.creation.box(bounds=bounds)], engine="manifold")
    return canonical(solid.vertices, solid.faces)


def main() -> None:
    """Write the file named on the command line, or block.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("block.obj")
    target.write_text(obj_text("block", *make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
