"""Draw one shape of a scene with an object of NiceGUI's scene, and change its place and colour afterwards."""

from collections.abc import Callable
from dataclasses import dataclass

from nicegui import ui
from nicegui.elements.scene.scene_object3d import Object3D

from voa_console.drawing.scene_objects import MeshCopy, PointsObject, PolylineObject
from voa_scene.shapes import AnyShape, Ball, Box, Cylinder, MeshShape, Points, Polyline, Quaternion, Text

Matrix = list[list[float]]
MeshUrl = Callable[[str], str]
"""Function that returns the address of an object's mesh."""
_ON_TOP = "scan"
"""Group of shapes that no other shape hides: the points of a scan lie on the object's surface, and inside of ghosts."""
_ROUND = 24
"""Number of faces around a cylinder, and of meridians of a ball."""
_UPRIGHT: Matrix = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
"""Rotation from the browser's cylinder, which lies along y, to one along z."""
_TEXT_STYLE = (
    "font-size: 12px; font-weight: 600; line-height: 1.1; padding: 0 3px; border-radius: 3px; white-space: nowrap; "
    "background: rgba(255, 255, 255, 0.85); color: #222; border-bottom: 2px solid {colour}"
)


@dataclass(frozen=True)
class Handle:
    """Drawn shape.

    Attributes:
        shape: that is drawn.
        body: object that shows the shape, and has its colour.
        carrier: object that is moved: the body, or for a shape that can be dragged a group on the table around it.
    """

    shape: AnyShape
    body: Object3D
    carrier: Object3D


def draw(scene: ui.scene, shape: AnyShape, mesh_url: MeshUrl, *, can_be_dragged: bool = False) -> Handle:
    """Draw a shape.

    Args:
        scene: to draw it in.
        shape: to draw.
        mesh_url: address of the mesh of an object.
        can_be_dragged: the shape can be dragged over the table.
    """
    if not can_be_dragged:
        body = _object(scene, shape, mesh_url)
        return place(Handle(shape, body, body), shape)
    with scene.group().draggable() as group:
        body = _object(scene, shape, mesh_url)
    return place(Handle(shape, body, group), shape)


def place(handle: Handle, shape: AnyShape) -> Handle:
    """Give a drawn shape the place and colour of `shape`, which has the same geometry; return the new handle."""
    x, y, z = shape.position
    if handle.carrier is not handle.body:
        handle.carrier.move(x, y, 0.0)
        handle.body.move(0.0, 0.0, z)
    else:
        handle.body.move(x, y, z)
    handle.body.rotate_R(rotation_of(shape))
    if not isinstance(shape, Text):  # a text has its colour in its style
        handle.body.material(shape.colour.hex, round(shape.colour.opacity, 3), "both")
    return Handle(shape, handle.body, handle.carrier)


def rotation_of(shape: AnyShape) -> Matrix:
    """Return the rotation of the object that draws a shape, as a 3 x 3 matrix."""
    rotation = rotation_matrix(shape.rotation)
    return _product(rotation, _UPRIGHT) if isinstance(shape, Cylinder) else rotation


def rotation_matrix(quaternion: Quaternion) -> Matrix:
    """Convert a unit quaternion w, x, y, z to a 3 x 3 matrix."""
    w, x, y, z = quaternion
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


def _product(left: Matrix, right: Matrix) -> Matrix:
    return [[sum(left[row][k] * right[k][column] for k in range(3)) for column in range(3)] for row in range(3)]


def _object(scene: ui.scene, shape: AnyShape, mesh_url: MeshUrl) -> Object3D:
    """Make the object of a shape, at the origin."""
    made: Object3D
    with scene:
        match shape:
            case MeshShape():
                made = MeshCopy(mesh_url(shape.object))
            case Box():
                made = scene.box(*shape.size)
            case Cylinder():
                made = scene.cylinder(shape.radius, shape.radius, shape.height, _ROUND)
            case Ball():
                made = scene.sphere(shape.radius, _ROUND, _ROUND // 2)
            case Polyline():
                made = PolylineObject(shape.points, shape.closed, shape.group == _ON_TOP)
            case Points():
                made = PointsObject(shape.points, shape.size, shape.group == _ON_TOP)
            case Text():
                made = scene.text(shape.text, _TEXT_STYLE.format(colour=shape.colour.hex))
    return made
