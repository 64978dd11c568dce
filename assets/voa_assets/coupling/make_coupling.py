"""Make coupling.obj: a body with two square ends, a rib in a recess of each, and two fins, from the measures below.

    python make_coupling.py [FILE]

Needs trimesh and manifold3d (the `dev` extra). The same versions give the same file, byte for byte.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from voa_assets.make_obj import Mesh, canonical, obj_text

_BEYOND = 0.01
"""Length by which cut-away volumes reach out of the coupling, so that no two faces lie in one plane."""

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class Coupling:
    """Measures of the coupling, in metres.

    Like the middle piece of an Oldham coupling it has a rib across each end, at right angles to each other. It is
    centred at the origin. The narrow end is at +z, its rib along x; the wide end at -z, its rib along y. The fins point
    along +x and -x at half the height, so that the coupling upside down has its fins at the same height.

    Attributes:
        height: of the coupling.
        narrow, wide: widths of the ends.
        wide_height: of the wide end.
        wall: thickness around the recesses.
        depth: of the recesses.
        rib: thickness of the ribs; they end flush with the coupling.
        fin_length, fin_width, fin_height: of a fin, from the outside of the narrow end.
    """

    height: float = 0.090
    narrow: float = 0.084
    wide: float = 0.120
    wide_height: float = 0.035
    wall: float = 0.006
    depth: float = 0.030
    rib: float = 0.010
    fin_length: float = 0.043
    fin_width: float = 0.010
    fin_height: float = 0.012


def make(coupling: Coupling | None = None) -> Mesh:
    """Make vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    c = coupling or Coupling()
    top, narrow, wide = c.height / 2.0, c.narrow / 2.0, c.wide / 2.0
    reach = narrow + c.fin_length
    body = trimesh.boolean.union(
        [
            _box((-narrow, -narrow, -c.fin_height), (narrow, narrow, top)),
            _box((-wide, -wide, -top), (wide, wide, c.wide_height - top)),
            _box((-reach, -c.fin_width / 2.0, -c.fin_height / 2.0), (reach, c.fin_width / 2.0, c.fin_height / 2.0)),
        ],
        engine="manifold",
    )
    solid = trimesh.boolean.difference([body, *_recess_of_narrow_end(c), *_recess_of_wide_end(c)], engine="manifold")
    return canonical(solid.vertices, solid.faces)


def _recess_of_narrow_end(c: Coupling) -> list[trimesh.Trimesh]:
    """Make the two volumes to cut away on either side of the rib along x."""
    inside, top = c.narrow / 2.0 - c.wall, c.height / 2.0
    return [
        _box((-inside, low, top - c.depth), (inside, high, top + _BEYOND))
        for low, high in ((c.rib / 2.0, inside), (-inside, -c.rib / 2.0))
    ]


def _recess_of_wide_end(c: Coupling) -> list[trimesh.Trimesh]:
    """Make the two volumes to cut away on either side of the rib along y."""
    inside, top = c.wide / 2.0 - c.wall, c.height / 2.0
    return [
        _box((low, -inside, -top - _BEYOND), (high, inside, c.depth - top))
        for low, high in ((c.rib / 2.0, inside), (-inside, -c.rib / 2.0))
    ]


def _box(low: Corner, high: Corner) -> trimesh.Trimesh:
    box: trimesh.Trimesh = trimesh.creation.box(bounds=np.array([low, high], dtype=np.float64))
    return box


def main() -> None:
    """Write the file named on the command line, or coupling.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("coupling.obj")
    target.write_text(obj_text("coupling", *make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
