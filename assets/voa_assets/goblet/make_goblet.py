"""Make goblet.obj: a square cup on a square foot, with a fin on one side of the cup, from the measures below.

    python make_goblet.py [FILE]

Needs trimesh and manifold3d (the `dev` extra). The same versions give the same file, byte for byte.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from voa_assets.make_obj import Mesh, canonical, obj_text

_BEYOND = 0.01
"""Length by which parts reach into each other and cut-away volumes out, so that no two faces lie in one plane."""


@dataclass(frozen=True)
class Goblet:
    """Measures of the goblet, in metres.

    The goblet is centred at the origin, the cup open towards +z, the fin pointing along +x at half the height, so that
    the goblet upside down has its fin at the same height.

    Attributes:
        height: of cup and foot together.
        foot_width, foot_height: of the square foot.
        cup_width: of the cup's outside.
        wall, floor: thicknesses of the cup.
        fin_length, fin_width, fin_height: of the fin, from the cup's outside.
    """

    height: float = 0.068
    foot_width: float = 0.046
    foot_height: float = 0.024
    cup_width: float = 0.090
    wall: float = 0.008
    floor: float = 0.006
    fin_length: float = 0.040
    fin_width: float = 0.030
    fin_height: float = 0.012


def make(goblet: Goblet | None = None) -> Mesh:
    """Make vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    g = goblet or Goblet()
    top, foot, cup = g.height / 2.0, g.foot_width / 2.0, g.cup_width / 2.0
    bottom_of_cup = g.foot_height - top
    solid = trimesh.boolean.union(
        [
            _box((-cup, -cup, bottom_of_cup), (cup, cup, top)),
            _box((-foot, -foot, -top), (foot, foot, bottom_of_cup + g.floor / 2.0)),
            _box((cup - g.wall / 2.0, -g.fin_width / 2.0, -g.fin_height / 2.0), (cup + g.fin_length, *_fin_end(g))),
        ],
        engine="manifold",
    )
    inside = cup - g.wall
    cavity = _box((-inside, -inside, bottom_of_cup + g.floor), (inside, inside, top + _BEYOND))
    solid = trimesh.boolean.difference([solid, cavity], engine="manifold")
    return canonical(solid.vertices, solid.faces)


def _fin_end(g: Goblet) -> tuple[float, float]:
    return g.fin_width / 2.0, g.fin_height / 2.0


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> trimesh.Trimesh:
    box: trimesh.Trimesh = trimesh.creation.box(bounds=np.array([low, high], dtype=np.float64))
    return box


def main() -> None:
    """Write the file named on the command line, or goblet.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("goblet.obj")
    target.write_text(obj_text("goblet", *make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
