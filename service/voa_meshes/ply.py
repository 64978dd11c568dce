"""PLY: vertices and polygons from the elements of a file."""

import numpy as np

from voa_meshes.ply_header import Header, read_header
from voa_meshes.ply_records import BytesRecords, Records, TextRecords
from voa_meshes.polygons import triangulated
from voa_meshes.text import narrow
from voa_meshes.triangles import Floats, Indices, Triangles, UnreadableMesh

_CORNERS = ("vertex_indices", "vertex_index")


def read_ply(content: bytes) -> Triangles:
    """Read a PLY file, as text or binary in either byte order; other elements and properties are ignored.

    Raises:
        UnreadableMesh: the header is not that of PLY, the file has fewer or more records than the header says, or a
            face is not a polygon.
    """
    content = narrow(content)
    header = read_header(content)
    corners = _corner_list(header)
    data = content[header.data_at :]
    source = TextRecords(data) if header.order is None else BytesRecords(data, header.order)
    read = {element.name: source.take(element) for element in header.elements}
    points = _points(read["vertex"])
    sizes, indices = _polygons(read["face"], corners, len(points))
    last = header.elements[-1]
    more = source.one_more(last)
    if more is not None and (last.name != "face" or _is_face(more, corners, len(points))):
        raise UnreadableMesh(f"the header says {last.count} of {last.name!a}, the file has more")
    return Triangles(points, triangulated(points, indices, sizes, lambda face: f"face {face + 1}"))


def _corner_list(header: Header) -> str:
    """Return the name of the property that lists the vertices of a face."""
    face = header.element("face")
    if header.element("tristrips") is not None:
        raise UnreadableMesh("triangle strips (tristrips) are not supported")
    if header.element("vertex") is None or face is None:
        raise UnreadableMesh("expected the elements 'vertex' and 'face' in the header")
    lists = [each for each in face.properties if each.name in _CORNERS and each.counted_by is not None]
    if len(lists) != 1 or lists[0].type.startswith("f"):
        raise UnreadableMesh("expected a list of whole numbers 'vertex_indices' in the element 'face'")
    return lists[0].name


def _points(vertices: Records) -> Floats:
    for axis in "xyz":
        if axis not in vertices.single:
            raise UnreadableMesh(f"expected the properties x, y and z in the element 'vertex', got no {axis}")
    return np.stack([vertices.single[axis] for axis in "xyz"], axis=1)


def _polygons(faces: Records, corners: str, vertices: int) -> tuple[Indices, Indices]:
    """Return how many corners each face has (f,), and the vertices at all corners, face by face."""
    sizes, numbers = faces.lists[corners]
    if len(sizes) and sizes.min() < 3:
        raise UnreadableMesh(f"face {int(np.argmin(sizes)) + 1} has {sizes.min()} corners, expected at least 3")
    wrong = np.flatnonzero(~((numbers >= 0) & (numbers < vertices) & (numbers == np.floor(numbers))))
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(sizes), wrong[0], side="right"))
        raise UnreadableMesh(f"face {face + 1} refers to vertex {numbers[wrong[0]]:g}, of vertices 0 to {vertices - 1}")
    return sizes, numbers.astype(np.int64)


def _is_face(record: Records, corners: str, vertices: int) -> bool:
    """Return True if a record could be one more face."""
    try:
        _, indices = _polygons(record, corners, vertices)
    except UnreadableMesh:
        return False
    return len(np.unique(indices)) == len(indices)
