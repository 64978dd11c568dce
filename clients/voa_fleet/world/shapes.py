"""Shapes of an object's solids, as `physics.json` states them.

Solids collide; the object's mesh itself is only seen by the lidar.
"""

from typing import Annotated, Literal

from annotated_types import Ge, Gt
from pydantic import ConfigDict, Field

from voa_msgs.described import Described

Vector = tuple[float, float, float]
Length = Annotated[float, Gt(0.0)]
Touches = Literal["table", "gripper", "both"]
"""Partners with which a solid collides: fewer pairs are faster, and a tube of boxes need not rest on the table."""


class Part(Described):
    """A part of `physics.json`; unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Box(Part):
    """A box along the axes of the object's frame."""

    kind: Literal["box"]
    centre: Vector
    size: tuple[Length, Length, Length]
    touches: Touches = "both"


class Cylinder(Part):
    """A cylinder from `start` to `end`."""

    kind: Literal["cylinder"]
    start: Vector
    end: Vector
    radius: Length
    touches: Touches = "both"


class Capsule(Part):
    """A cylinder from `start` to `end` with a half ball at each end."""

    kind: Literal["capsule"]
    start: Vector
    end: Vector
    radius: Length
    touches: Touches = "both"


class Tube(Part):
    """A wall of `pieces` boxes around the line from `start` to `end`."""

    kind: Literal["tube"]
    start: Vector
    end: Vector
    radius: Length
    """Radius of the outside."""
    wall: Length
    pieces: Annotated[int, Ge(3)]
    touches: Touches = "both"


class MeshHull(Part):
    """The convex hull of the object's mesh: exact on a table, because nothing else of the object can touch a plane."""

    kind: Literal["hull"]
    touches: Touches = "table"


class Hulls(Part):
    """Convex pieces from a file in the object's folder, for a mesh of any shape."""

    kind: Literal["hulls"]
    file: Annotated[str, Field(min_length=1)]
    """OBJ file in the object's folder, in metres and in the object's frame; each `o` or `g` group is one piece."""
    touches: Touches = "both"


Solid = Annotated[Box | Cylinder | Capsule | Tube | MeshHull | Hulls, Field(discriminator="kind")]
