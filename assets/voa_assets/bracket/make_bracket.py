"""Make bracket.obj: an angle of two flat legs of different lengths, from the measures below.

    python make_bracket.py [FILE]

Needs numpy alone. The same measures give the same file, byte for byte.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from voa_assets.make_obj import Mesh, canonical, obj_text


@dataclass(frozen=True)
class Bracket:
    """Measures of the bracket, in metres.

    The middles of the two legs cross at the origin: the long one points along +x, the short one along +y. The width
    lies along z, to both sides.

    Attributes:
        long, short: from the outside of the corner to the end of each leg.
        thickness: of both legs.
        width: of both legs.
    """

    long: float = 0.100
    short: float = 0.070
    thickness: float = 0.010
    width: float = 0.040


def make(bracket: Bracket | None = None) -> Mesh:
    """Vertices (v, 3) in metres and faces (f, 3) of the closed surface, counter-clockwise seen from outside."""
    b = bracket or Bracket()
    half = b.thickness / 2.0
    outline = np.array(
        [
            [-half, -half],
            [b.long - half, -half],
            [b.long - half, half],
            [half, half],
            [half, b.short - half],
            [-half, b.short - half],
        ]
    )
    count = len(outline)
    vertices = np.vstack([np.column_stack([outline, np.full(count, z)]) for z in (-b.width / 2.0, b.width / 2.0)])
    # Both caps are fans about the inside of the corner, which sees every other corner.
    inner = 3
    fan = [[inner, (inner + k) % count, (inner + k + 1) % count] for k in range(1, count - 1)]
    bottom = [[a, c, b_] for a, b_, c in fan]
    top = [[a + count, b_ + count, c + count] for a, b_, c in fan]
    sides = []
    for k in range(count):
        after = (k + 1) % count
        sides += [[k, after, after + count], [k, after + count, k + count]]
    return canonical(vertices, np.array(bottom + top + sides))


def main() -> None:
    """Write the file named on the command line, or bracket.obj beside this one."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("bracket.obj")
    target.write_text(obj_text("bracket", *make()), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
