"""A small concave solid as a mesh file of every type and dialect, and what is the same however it is cut up."""

import json
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from voa_meshes.triangles import Triangles

Polygons = list[list[int]]

OUTLINE = [(-0.05, -0.02), (0.03, -0.02), (0.03, 0.01), (-0.01, 0.01), (-0.01, 0.05), (-0.05, 0.05)]
HEIGHT = 0.06
POINTS = np.array([(x, y, z) for z in (0.0, HEIGHT) for x, y in OUTLINE])
"""A step seen from above: two hexagons over each other; (12, 3), metres."""
POLYGONS: Polygons = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]] + [
    [k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)
]
CUT: Polygons = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
TRIANGLES: Polygons = [face[::-1] for face in CUT] + [[a + 6, b + 6, c + 6] for a, b, c in CUT]
TRIANGLES += [half for a, b, c, d in POLYGONS[2:] for half in ([a, b, c], [a, c, d])]
CORNERS = POINTS[np.array(TRIANGLES)]


def measures(mesh: Triangles) -> NDArray[np.float64]:
    """Volume, its first moments, and area vectors' sum: the same for all ways to cut a closed solid into triangles."""
    corners = mesh.vertices[mesh.faces]
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    moments = (volumes[:, None] * corners.sum(axis=1) / 4.0).sum(axis=0)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    return np.array([volumes.sum(), *moments, area, *normals.sum(axis=0)])


SOLID = measures(Triangles(POINTS, np.array(TRIANGLES)))


def assert_solid(mesh: Triangles, times: int = 1, within: float = 1e-9) -> None:
    """Assert that a mesh is the solid, in its place."""
    np.testing.assert_allclose(measures(mesh), times * SOLID, rtol=0.0, atol=within)


def numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def obj(polygons: Polygons = POLYGONS, points: ArrayLike = POINTS) -> str:
    lines = [f"v {numbers(point)}" for point in np.asarray(points)]
    return "\n".join(lines + ["f " + " ".join(str(index + 1) for index in polygon) for polygon in polygons]) + "\n"


def ascii_stl(corners: ArrayLike = CORNERS, name: str = "step") -> str:
    facets = [
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {numbers(corner)}\n" for corner in facet)
        + " endloop\nendfacet\n"
        for facet in np.asarray(corners)
    ]
    return f"solid {name}\n" + "".join(facets) + f"endsolid {name}\n"


def binary_stl(corners: ArrayLike = CORNERS, claimed: int | None = None, head: bytes = b"") -> bytes:
    facets = np.asarray(corners, dtype=np.float64)
    body = b"".join(struct.pack("<12fH", 0.0, 0.0, 1.0, *facet.reshape(-1), 0) for facet in facets)
    return head.ljust(80, b" ") + struct.pack("<I", len(facets) if claimed is None else claimed) + body


def ply_header(
    format_: str, vertices: int = len(POINTS), faces: int = len(POLYGONS), coordinate: str = "double"
) -> str:
    lines = ["ply", f"format {format_} 1.0", "comment a step", f"element vertex {vertices}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    return "\n".join([*lines, f"element face {faces}", "property list uchar int vertex_indices", "end_header"]) + "\n"


def ascii_ply(polygons: Polygons = POLYGONS, points: ArrayLike = POINTS, **counts: int) -> str:
    said = {"vertices": len(np.asarray(points)), "faces": len(polygons)} | counts
    rows = [numbers(point) for point in np.asarray(points)]
    rows += [" ".join(map(str, [len(polygon), *polygon])) for polygon in polygons]
    return ply_header("ascii", said["vertices"], said["faces"]) + "\n".join(rows) + "\n"


def binary_ply(polygons: Polygons = POLYGONS, points: ArrayLike = POINTS, order: str = "<", **counts: int) -> bytes:
    said = {"vertices": len(np.asarray(points)), "faces": len(polygons)} | counts
    header = ply_header(
        "binary_little_endian" if order == "<" else "binary_big_endian", said["vertices"], said["faces"]
    )
    body = b"".join(struct.pack(f"{order}3d", *point) for point in np.asarray(points))
    return header.encode() + body + b"".join(struct.pack(f"{order}B{len(p)}i", len(p), *p) for p in polygons)


class Gltf:
    """A glTF document with its buffer, put together piece by piece."""

    def __init__(self) -> None:
        self.document: dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]}
        self.document |= {"nodes": [{"mesh": 0}], "bufferViews": [], "accessors": [], "meshes": []}
        self.blob = b""

    def view(self, content: bytes, **more: Any) -> int:
        """Add bytes; the index of their buffer view."""
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(content)} | more
        self.blob += content + bytes(-len(content) % 4)
        self.document["bufferViews"].append(view)
        return len(self.document["bufferViews"]) - 1

    def accessor(self, values: ArrayLike, dtype: str, type_: str, component: int, **more: Any) -> int:
        """Add numbers; the index of their accessor."""
        content = np.asarray(values).astype(dtype)
        accessor = {"bufferView": self.view(content.tobytes()), "count": len(content), "type": type_}
        self.document["accessors"].append(accessor | {"componentType": component} | more)
        return len(self.document["accessors"]) - 1

    def positions(self, points: ArrayLike) -> int:
        return self.accessor(points, "<f4", "VEC3", 5126)

    def indices(self, indices: ArrayLike) -> int:
        return self.accessor(np.asarray(indices).reshape(-1), "<u2", "SCALAR", 5123)

    def mesh(self, *primitives: dict[str, Any], **more: Any) -> int:
        self.document["meshes"].append({"primitives": list(primitives)} | more)
        return len(self.document["meshes"]) - 1

    def triangles(self, points: ArrayLike = POINTS, faces: ArrayLike = TRIANGLES, **more: Any) -> dict[str, Any]:
        """A primitive of triangles."""
        return {"attributes": {"POSITION": self.positions(points)}, "indices": self.indices(faces)} | more

    def file(self, **changes: Any) -> bytes:
        """The GLB file."""
        said: dict[str, Any] = {"buffers": [{"byteLength": len(self.blob)}]} if self.blob else {}
        return glb(self.document | said | changes, self.blob)


def step() -> Gltf:
    """The solid in one primitive, as the file's frame has it."""
    made = Gltf()
    made.mesh(made.triangles())
    return made


def glb(document: dict[str, Any], blob: bytes = b"") -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if blob:
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def changed(lines: str, *changes: tuple[str, str]) -> str:
    """Text with each part replaced that must be there."""
    for old, new in changes:
        assert old in lines
        lines = lines.replace(old, new, 1)
    return lines


def rolled(polygons: Polygons, by: int) -> Polygons:
    """Polygons that begin at another corner."""
    return [[*polygon[by % len(polygon) :], *polygon[: by % len(polygon)]] for polygon in polygons]


def row(values: Sequence[int]) -> str:
    return " ".join(map(str, values))
