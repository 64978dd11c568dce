"""Models of a mesh at several poses, as binary glTF (GLB): the mesh once, and a node and a material for each copy.

A `ModelPrimitive` of Foxglove has data of its own, so that one per copy would repeat the mesh up to 60 times in each
scene. glTF is also the one format whose up axis (+Y) Foxglove does not take from a setting of the panel, as it does for
STL: the root node turns this project's z into it.
"""

import json
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from voa_scene.shapes import Colour, MeshShape

MEDIA_TYPE = "model/gltf-binary"

_STL_HEADER, _STL_FACE, _STL_NORMAL, _STL_VERTEX = 84, 50, 12, 12
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_Z_UP = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Rotation x, y, z, w that turns z up into glTF's y up."""


@dataclass(frozen=True)
class IndexedMesh:
    """Mesh as glTF stores it: each vertex once, and three indices per face.

    Attributes:
        vertices: x, y, z of each vertex, metres, float32, little endian.
        indices: of the corners of each face, uint32, little endian.
    """

    vertices: bytes
    indices: bytes


def indexed_mesh(stl: bytes) -> IndexedMesh:
    """Read a binary STL file; raises ValueError if it is none, or has no face."""
    faces = (len(stl) - _STL_HEADER) // _STL_FACE
    if faces < 1 or struct.unpack_from("<I", stl, _STL_HEADER - 4)[0] != faces:
        raise ValueError(f"expected a binary STL file with at least one face, got {len(stl)} bytes")
    numbers: dict[bytes, int] = {}
    firsts = [_STL_HEADER + face * _STL_FACE + _STL_NORMAL for face in range(faces)]
    starts = [start for first in firsts for start in range(first, first + 3 * _STL_VERTEX, _STL_VERTEX)]
    corners = [numbers.setdefault(stl[start : start + _STL_VERTEX], len(numbers)) for start in starts]
    return IndexedMesh(b"".join(numbers), struct.pack(f"<{len(corners)}I", *corners))


def model_of(mesh: IndexedMesh, copies: Sequence[MeshShape]) -> bytes:
    """Write a GLB file that shows a mesh at the position and in the colour of each of some shapes, at least one."""
    content = json.dumps(_document(mesh, copies), separators=(",", ":")).encode()
    content += b" " * (-len(content) % 4)
    binary = mesh.vertices + mesh.indices
    chunks = struct.pack("<I4s", len(content), b"JSON") + content + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _document(mesh: IndexedMesh, copies: Sequence[MeshShape]) -> dict[str, Any]:
    points = list(struct.iter_unpack("<3f", mesh.vertices))
    vertices = {"buffer": 0, "byteOffset": 0, "byteLength": len(mesh.vertices), "target": _VERTICES}
    indices = {
        "buffer": 0, "byteOffset": len(mesh.vertices), "byteLength": len(mesh.indices), "target": _INDICES,
    }  # fmt: skip
    corners = {"bufferView": 1, "componentType": _UNSIGNED, "count": len(mesh.indices) // 4, "type": "SCALAR"}
    positions = {
        "bufferView": 0, "componentType": _FLOAT, "count": len(points), "type": "VEC3",
        "min": [min(axis) for axis in zip(*points, strict=True)],
        "max": [max(axis) for axis in zip(*points, strict=True)],
    }  # fmt: skip
    numbers = range(len(copies))
    return {
        "asset": {"version": "2.0", "generator": "voa"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "z up", "rotation": _Z_UP, "children": [number + 1 for number in numbers]},
            *(_node(copy, number) for number, copy in enumerate(copies)),
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": number}]} for number in numbers
        ],
        "materials": [_material(copy.colour) for copy in copies],
        "buffers": [{"byteLength": len(mesh.vertices) + len(mesh.indices)}],
        "bufferViews": [vertices, indices],
        "accessors": [positions, corners],
    }


def _node(copy: MeshShape, number: int) -> dict[str, Any]:
    w, x, y, z = copy.rotation
    return {"name": copy.name, "mesh": number, "translation": copy.position, "rotation": (x, y, z, w)}


def _material(colour: Colour) -> dict[str, Any]:
    """Dull material; glTF's colours are linear, those of shapes sRGB."""
    red, green, blue = (_linear(part) for part in (colour.red, colour.green, colour.blue))
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, colour.opacity],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "alphaMode": "BLEND" if colour.opacity < 1.0 else "OPAQUE",
        "doubleSided": True,
    }


def _linear(part: float) -> float:
    return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
