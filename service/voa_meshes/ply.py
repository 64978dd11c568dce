"""PLY: what its elements say about vertices and polygons."""

import numpy as np

from voa_meshes.ply_header import Header, read_header
from voa_meshes.ply_records import BytesRecords, Records, TextRecords
from voa_meshes.polygons import triangulated
from voa_meshes.text import narrow
from voa_meshes.triangles import Floats, Indices, Triangles, Unreadable

_CORNERS = ("vertex_indices", "vertex_index")


def read_ply(content: bytes) -> Triangles:
    """Read a PLY file, text or bytes of either order; other elements and properties are passed over.

    Raises:
        Unreadable: the header is none, the file has fewer or more records than it says, or the faces are not polygons.
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
        raise Unreadable(f"the header says {last.count} of {last.name!a}, the file has more")
    return Triangles(points, triangulated(points, indices, sizes, lambda face: f"face {face + 1}"))


def _corner_list(header: Header) -> str:
    """The name of the list of a face's vertices."""
    face = header.element("face")
    if header.element("tristrips") is not None:
        raise Unreadable("triangle strips (tristrips) are not supported")
    if header.element("vertex") is None or face is None:
        raise Unreadable("expected the elements 'vertex' and 'face' in the header")
    found = [each for each in face.properties if each.name in _CORNERS and each.counted_by is not None]
    if len(found) != 1 or found[0].type.startswith("f"):
        raise Unreadable("expected a list of whole numbers 'vertex_indices' in the element 'face'")
    return found[0].name


def _points(vertices: Records) -> Floats:
    for axis in "xyz":
        if axis not in vertices.single:
            raise Unreadable(f"expected the properties x, y and z in the element 'vertex', got no {axis}")
    return np.stack([vertices.single[axis] for axis in "xyz"], axis=1)


def _polygons(faces: Records, corners: str, vertices: int) -> tuple[Indices, Indices]:
    """How many corners each face has, and the vertices at them."""
    sizes, numbers = faces.lists[corners]
    if len(sizes) and sizes.min() < 3:
        raise Unreadable(f"face {int(np.argmin(sizes)) + 1} has {sizes.min()} corners, expected at least 3")
    wrong = np.flatnonzero(~((numbers >= 0) & (numbers < vertices) & (numbers == np.floor(numbers))))
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(sizes), wrong[0], side="right"))
        raise Unreadable(f"face {face + 1} refers to vertex {numbers[wrong[0]]:g}, of vertices 0 to {vertices - 1}")
    return sizes, numbers.astype(np.int64)


def _is_face(record: Records, corners: str, vertices: int) -> bool:
    """Whether a record could be one more face."""
    try:
        _, indices = _polygons(record, corners, vertices)
    except Unreadable:
        return False
    return len(np.unique(indices)) == len(indices)
