"""Scene of a session as a `visualization_msgs/msg/MarkerArray`: a marker for each shape.

Each array begins with a marker that deletes all earlier ones of its display, so that it is complete in itself: nothing
remains of an older version, whichever process published that. Namespaces are the groups of shapes: `table`, `belief`,
`looks`, `scan`, `robot`, `grasp`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count

from voa_ros.outputs.fields import Fields, header, point, pose
from voa_scene.shapes import (
    AnyShape,
    Ball,
    Box,
    Colour,
    Cylinder,
    MeshShape,
    Points,
    Polyline,
    Scene,
    Text,
    Vector,
)

ADD, DELETE_ALL = 0, 3
CUBE, SPHERE, CYLINDER, LINE_STRIP, POINTS, TEXT, MESH, TRIANGLES = 1, 2, 3, 4, 8, 9, 10, 11
MOST_MESHES = 8
"""Most poses that are drawn as triangles, where tools cannot read the mesh from the service."""
MOST_FACES = 2_000
"""Most faces of the mesh that tools read from the service."""


@dataclass(frozen=True)
class MeshSource:
    """Mesh of the object for the markers: an address at which tools read it, or its triangles.

    Attributes:
        address: of the service, without a slash at its end; None: tools cannot read the mesh from it.
        corners: three for each triangle, in the mesh's own frame, metres; empty: not known.
    """

    address: str | None = None
    corners: Sequence[Vector] = ()

    @cached_property
    def points(self) -> list[Fields]:
        """Corners as points of a message: one list, which the markers of all poses share."""
        return [point(corner) for corner in self.corners]


def marker_array(scene: Scene, frame_id: str, mesh: MeshSource | None = None) -> Fields:
    """Make the markers of a scene.

    Args:
        scene: shapes in the world frame.
        frame_id: name of the world frame.
        mesh: of the object; None: the object is not drawn.
    """
    source = MeshSource() if mesh is None else mesh
    meshes = [shape for shape in scene.shapes if isinstance(shape, MeshShape)]
    drawn = meshes if source.address is not None else _strongest(meshes)
    numbers = count()
    markers: list[Fields] = [{"header": header(frame_id), "action": DELETE_ALL, "pose": pose((0, 0, 0), (1, 0, 0, 0))}]
    for shape in scene.shapes:
        if isinstance(shape, MeshShape) and shape not in drawn:
            continue
        own = _geometry(shape, source)
        if own is not None:
            markers.append(_common(shape, frame_id, next(numbers)) | own)
    return {"markers": markers}


def _strongest(meshes: Sequence[MeshShape]) -> list[MeshShape]:
    """Select the most opaque meshes, which are those of the likeliest poses."""
    return sorted(meshes, key=lambda shape: -shape.colour.opacity)[:MOST_MESHES]


def _common(shape: AnyShape, frame_id: str, number: int) -> Fields:
    return {
        "header": header(frame_id),
        "ns": shape.group,
        "id": number,
        "action": ADD,
        "pose": pose(shape.position, shape.rotation),
        "color": _colour(shape.colour),
    }


def _colour(colour: Colour) -> Fields:
    return {"r": colour.red, "g": colour.green, "b": colour.blue, "a": colour.opacity}


def _geometry(shape: AnyShape, mesh: MeshSource) -> Fields | None:
    """Return the fields that depend on the class of a shape; None: it cannot be drawn."""
    match shape:
        case MeshShape():
            return _mesh(shape, mesh)
        case Box(size=size):
            return {"type": CUBE, "scale": point(size)}
        case Cylinder(radius=radius, height=height):
            return {"type": CYLINDER, "scale": point((2.0 * radius, 2.0 * radius, height))}
        case Ball(radius=radius):
            return {"type": SPHERE, "scale": point((2.0 * radius,) * 3)}
        case _:
            return _thin(shape)


def _thin(shape: Polyline | Points | Text) -> Fields:
    """Return the fields of a shape without a volume."""
    match shape:
        case Polyline(points=points, closed=closed, width=width):
            corners = [*points, points[0]] if closed else points
            return {"type": LINE_STRIP, "scale": point((width, 0.0, 0.0)), "points": [point(each) for each in corners]}
        case Points(points=points, size=size):
            return {"type": POINTS, "scale": point((size, size, 0.0)), "points": [point(each) for each in points]}
        case Text(text=text, size=size):
            return {"type": TEXT, "scale": point((0.0, 0.0, size)), "text": text}


def _mesh(shape: MeshShape, mesh: MeshSource) -> Fields | None:
    if mesh.address is not None:
        resource = f"{mesh.address}/v1/objects/{shape.object}/mesh.stl?most_faces={MOST_FACES}"
        return {"type": MESH, "scale": point((1.0, 1.0, 1.0)), "mesh_resource": resource}
    if not mesh.corners:
        return None
    return {"type": TRIANGLES, "scale": point((1.0, 1.0, 1.0)), "points": mesh.points}
