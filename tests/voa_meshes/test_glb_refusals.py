"""GLB that is not supported, not whole or not glTF is refused, and the reason names it."""

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.voa_meshes.files import POINTS, Gltf, glb, step
from voa_meshes.glb import read_glb
from voa_meshes.triangles import UnreadableMesh

Made = Callable[[], bytes]


def changed(change: Callable[[Gltf], None], **more: Any) -> Made:
    def make() -> bytes:
        made = step()
        change(made)
        return made.file(**more)

    return make


def primitive(**changes: Any) -> Made:
    return changed(lambda made: made.document["meshes"][0]["primitives"][0].update(changes))


def accessor(index: int, **changes: Any) -> Made:
    return changed(lambda made: made.document["accessors"][index].update(changes))


def view(**changes: Any) -> Made:
    return changed(lambda made: made.document["bufferViews"][0].update(changes))


def file(**changes: Any) -> Made:
    return lambda: step().file(**changes)


def sparse(places: list[int], **more: Any) -> Made:
    def change(made: Gltf) -> None:
        indices = {"bufferView": made.view(np.array(places, dtype="u1").tobytes()), "componentType": 5121} | more
        values = {"bufferView": made.view(POINTS[: len(places)].astype("<f4").tobytes())}
        made.document["accessors"][0]["sparse"] = {"count": len(places), "indices": indices, "values": values}

    return changed(change)


def in_draco_alone(made: Gltf) -> None:
    made.document["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}
    del made.document["accessors"][0]["bufferView"]


def short(content: bytes) -> bytes:
    cut = content[:-10]
    return cut[:8] + struct.pack("<I", len(cut)) + cut[12:]


def nested() -> bytes:
    text = b'{"asset":' + b"[" * 100_000
    chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunk)) + chunk


MESHOPT = {"EXT_meshopt_compression": {"buffer": 0, "byteLength": 4}}
REFUSED: dict[str, tuple[Made, str]] = {
    "points": (primitive(mode=0), r"points \(mode 0\) are not a surface"),
    "lines": (primitive(mode=1), r"lines \(mode 1\) are not a surface"),
    "line strips": (primitive(mode=3), r"line strips \(mode 3\)"),
    "another mode": (primitive(mode=7), "glTF has no mode 7"),
    "no positions": (primitive(attributes={"NORMAL": 0}), "no POSITION"),
    "Draco": (
        file(extensionsRequired=["KHR_draco_mesh_compression"]),
        r"Draco compression \(KHR_draco_mesh_compression\)",
    ),
    "Draco that is not required": (changed(in_draco_alone), "Draco compression"),
    "meshopt": (
        file(extensionsRequired=["EXT_meshopt_compression"]),
        r"meshopt compression \(EXT_meshopt_compression\)",
    ),
    "meshopt that is not required": (view(extensions=MESHOPT, byteLength=10**6), "meshopt compression"),
    "a buffer that meshopt fills": (
        file(buffers=[{"byteLength": 10, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}]),
        "meshopt compression",
    ),
    "an extension that nobody knows": (
        file(extensionsRequired=["ACME_gears"]),
        "glTF extension 'ACME_gears' is not supp",
    ),
    "an extension with a wild name": (file(extensionsRequired=["a\nb" * 99]), "glTF extension 'a"),
    "a skin": (file(nodes=[{"mesh": 0, "skin": 0}]), r"a skin \(node 0\) is not supported"),
    "an external buffer": (
        file(buffers=[{"byteLength": 9, "uri": "step.bin"}]),
        "external buffer is not supported, 'step",
    ),
    "an address": (
        file(buffers=[{"byteLength": 9, "uri": "http://127.0.0.1/x"}]),
        "external buffer is not supported, 'http:",
    ),
    "a buffer that is not there": (
        file(buffers=[{"byteLength": 9}, {"byteLength": 9}], bufferViews=[{"buffer": 1, "byteLength": 9}] * 2),
        "buffer 1 has no bytes",
    ),
    "a buffer that is cut off": (file(buffers=[{"byteLength": 10**6}]), "buffer 0 claims 1000000 bytes"),
    "a buffer that is not base64": (file(buffers=[{"byteLength": 9, "uri": "data:;base64,***"}]), "marked as base64"),
    "an index beyond the end": (
        changed(lambda made: made.document["meshes"][0]["primitives"][0].update(indices=made.indices([0, 1, 12]))),
        "refers to vertex 12, of vertices 0 to 11",
    ),
    "a corner too many": (accessor(1, count=59), "3 corners for each triangle, got 59"),
    "signed indices": (accessor(1, componentType=5122), "accessor 1: expected unsigned whole numbers"),
    "indices of two": (accessor(1, type="VEC2"), "accessor 1: expected unsigned whole numbers"),
    "positions of four": (accessor(0, type="VEC4"), "accessor 0: expected VEC3, got 'VEC4'"),
    "no such component type": (accessor(0, componentType=5130), "no glTF component type 5130"),
    "normalised fractions": (accessor(0, normalized=True), "component type 5126 cannot be normalised"),
    "more elements than bytes": (accessor(0, count=13), "accessor 0: expected 13 elements of 12 bytes"),
    "an offset beyond the end": (accessor(0, byteOffset=4), "accessor 0: expected 12 elements"),
    "a view beyond the buffer": (view(byteOffset=10**6), "accessor 0: expected 12 elements"),
    "elements over each other": (view(byteStride=4), "accessor 0: expected 12 elements"),
    "a sparse index beyond the end": (sparse([0, 12]), "the sparse accessor 0: expected rising indices below 12"),
    "sparse indices that do not rise": (sparse([3, 3]), "the sparse accessor 0: expected rising indices"),
    "sparse indices that are signed": (sparse([3], componentType=5120), "the sparse accessor 0: expected unsigned"),
    "a node below itself": (file(nodes=[{"mesh": 0, "children": [0]}]), "node 0 is a child of two nodes, or of itself"),
    "a node below two": (file(nodes=[{"children": [1, 1]}, {"mesh": 0}]), "node 1 is a child of two nodes"),
    "no such node": (file(scenes=[{"nodes": [5]}]), "it refers to node 5, but has only 1"),
    "no such mesh": (file(nodes=[{"mesh": 5}]), "it refers to mesh 5, but has only 1"),
    "no such accessor": (primitive(attributes={"POSITION": 9}), "it refers to accessor 9, but has only 2"),
    "no such scene": (file(scene=4), "it refers to scene 4, but has only 1"),
    "two scenes and none named": (file(scenes=[{"nodes": [0]}] * 2, scene=None), "it has 2 scenes"),
    "no scene": (file(scenes=[], scene=None), "it has 0 scenes"),
    "a scene without meshes": (file(nodes=[{}]), "its scene has no mesh"),
    "a mesh without primitives": (file(meshes=[{"primitives": []}]), "a mesh has no primitives"),
    "a rotation by nothing": (file(nodes=[{"mesh": 0, "rotation": [0, 0, 0, 0]}]), "a quaternion of length 1"),
    "a projection": (file(nodes=[{"mesh": 0, "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]), "last row"),
    "a matrix of 3 x 3": (file(nodes=[{"mesh": 0, "matrix": [1] * 9}]), "nodes.0.matrix: List should have at least 16"),
    "morph targets without their weights": (
        changed(
            lambda made: made.document["meshes"][0].update(
                weights=[1.0, 1.0], primitives=[made.triangles(targets=[{}])]
            )
        ),
        "2 weights for 1 morph targets",
    ),
    "a morph target of another mesh": (
        changed(
            lambda made: made.document["meshes"][0].update(
                weights=[1.0], primitives=[made.triangles(targets=[{"POSITION": made.positions(POINTS[:3])}])]
            )
        ),
        "a morph target has 3 vertices, its mesh 12",
    ),
    "instances without places": (
        file(nodes=[{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]),
        "expected attrib",
    ),
    "instances of different numbers": (
        file(
            nodes=[
                {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0, "SCALE": 2}}}}
            ]
        ),
        "accessor 2, but has only 2",
    ),
    "words for numbers": (file(nodes=[{"mesh": "0"}]), "nodes.0.mesh: Input should be a valid integer"),
    "an index below 0": (file(nodes=[{"mesh": -1}]), "nodes.0.mesh: Input should be greater than or equal to 0"),
    "version 1 of glTF": (file(asset={"version": "1.0"}), "expected glTF 2.0, got '1.0'"),
    "a later glTF": (file(asset={"version": "2.1", "minVersion": "2.1"}), "expected glTF 2.0, got '2.1'"),
    "version 1 of GLB": (lambda: b"glTF" + struct.pack("<II", 1, 12), "expected glTF 2, got version 1"),
    "a .gltf file": (lambda: b'{"asset": {"version": "2.0"}}', "a file that begins with 'glTF'"),
    "a file that is cut off": (lambda: step().file()[:-10], "the header says .* bytes, the file has .*: is it cut off"),
    "a chunk that is cut off": (lambda: short(step().file()), "a chunk claims .* is the file cut off"),
    "a header alone": (lambda: b"glTF" + struct.pack("<II", 2, 12), "a chunk of JSON first"),
    "less than a header": (lambda: b"glTF", "the header of a GLB file"),
    "JSON that is none": (lambda: glb({}).replace(b"{}", b"{["), "its glTF document is not as expected"),
    "JSON nested without end": (nested, "its glTF document is not as expected"),
}


@pytest.mark.parametrize(("made", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_supported_is_named(made: Made, says: str) -> None:
    with pytest.raises(UnreadableMesh, match=says) as refused:
        read_glb(made())
    assert "\n" not in str(refused.value)
