"""Shapes of a scene: plain values in the world frame (metres, z up), which every viewer can draw.

A viewer draws each shape by its class, and none needs to know what the shape stands for: `group` and `name` say that to
people and let a viewer replace a shape when it changes.
"""

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""Rotation as w, x, y, z, of length 1."""
Group = Literal["table", "belief", "looks", "scan", "robot", "grasp"]
"""Group of a shape: a viewer can hide the shapes of a group, and ROS tools see it as the namespace of a marker."""
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Colour:
    """Colour: red, green, blue and opacity, each 0 to 1."""

    red: float
    green: float
    blue: float
    opacity: float = 1.0

    @property
    def hex(self) -> str:
        """Colour without its opacity, as `#rrggbb`."""
        return "#" + "".join(f"{round(255 * part):02x}" for part in (self.red, self.green, self.blue))

    def faded(self, opacity: float) -> "Colour":
        """Return the same colour with another opacity."""
        return Colour(self.red, self.green, self.blue, opacity)


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Shape of a scene.

    Attributes:
        group: of the shape.
        name: unique within the group; a shape of a later scene with the same group and name replaces it.
        label: text for people who point at the shape; empty: none.
        position: of the shape's own origin, metres.
        rotation: of the shape about its origin.
        colour: with its opacity.
    """

    group: Group
    name: str
    label: str = ""
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = IDENTITY
    colour: Colour


@dataclass(frozen=True, kw_only=True)
class MeshShape(Shape):
    """Copy of the mesh of the scenario's object.

    Attributes:
        object: identifier of the object, whose mesh is drawn.
    """

    object: str


@dataclass(frozen=True, kw_only=True)
class Box(Shape):
    """Box that is centred at its origin.

    Attributes:
        size: lengths of the edges along the axes of the shape, metres.
    """

    size: Vector


@dataclass(frozen=True, kw_only=True)
class Cylinder(Shape):
    """Cylinder along the z axis of the shape, centred at its origin.

    Attributes:
        radius, height: metres.
    """

    radius: float
    height: float


@dataclass(frozen=True, kw_only=True)
class Ball(Shape):
    """Ball about its origin.

    Attributes:
        radius: metres.
    """

    radius: float


@dataclass(frozen=True, kw_only=True)
class Polyline(Shape):
    """Line through points; the points are relative to the origin of the shape.

    Attributes:
        points: at least two, metres.
        closed: the last point is joined to the first.
        width: of the line where a viewer draws lines with a width, metres.
    """

    points: tuple[Vector, ...]
    closed: bool = False
    width: float = 0.002


@dataclass(frozen=True, kw_only=True)
class Points(Shape):
    """Points, which are relative to the origin of the shape.

    Attributes:
        points: metres.
        size: of each point, metres.
    """

    points: tuple[Vector, ...]
    size: float = 0.004


@dataclass(frozen=True, kw_only=True)
class Text(Shape):
    """Text that faces the viewer; `name` identifies it and `text` is shown.

    Attributes:
        text: in one line.
        size: height of a capital letter, metres.
    """

    text: str
    size: float = 0.02


AnyShape = MeshShape | Box | Cylinder | Ball | Polyline | Points | Text
"""Every class of shape that a viewer draws."""


@dataclass(frozen=True)
class Scene:
    """Scene: the shapes of a session at one version.

    Attributes:
        shapes: in the order in which they were made; each has its own group and name.
    """

    shapes: tuple[AnyShape, ...]

    def of(self, group: Group) -> tuple[AnyShape, ...]:
        """Return the shapes of a group."""
        return tuple(shape for shape in self.shapes if shape.group == group)
