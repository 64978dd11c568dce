"""GLB: every way to write a scene of triangles gives the solid where it is; what is not supported is named."""

import base64
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.voa_service.meshes.files import POINTS, SOLID, TRIANGLES, Gltf, assert_solid, glb, measures, step
from voa_service.meshes.glb import read_glb
from voa_service.meshes.triangles import Unreadable

FLOAT32 = 1e-8
TURNED = [0.5, 0.5, 0.5, 0.5]  # x to y to z to x
Made = Callable[[], bytes]


def of_soup() -> bytes:
    made = Gltf()
    made.mesh({"attributes": {"POSITION": made.positions(POINTS[np.array(TRIANGLES)].reshape(-1, 3))}})
    return made.file()


def of_fans() -> bytes:
    """Bottom and top as fans around the corner that sees all others, the sides as strips."""
    made = Gltf()
    bottom, top = [3, 2, 1, 0, 5, 4], [9, 10, 11, 6, 7, 8]
    ring = [k for pair in zip([*range(6, 12), 6], [*range(6), 0], strict=True) for k in pair]
    fans = [made.triangles(faces=fan, mode=6) for fan in (bottom, top)]
    made.mesh(*fans, made.triangles(faces=ring, mode=5))
    return made.file()


def of_strips_with_empty_triangles() -> bytes:
    made = Gltf()
    stitched: list[int] = []
    for a, b, c in TRIANGLES:
        stitched += [a, a] if stitched else []
        stitched += [a, b, c, c]
    made.mesh(made.triangles(faces=stitched, mode=5))
    return made.file()


def of_parts() -> bytes:
    """Half of the triangles in a primitive, half in another mesh at another node."""
    made = Gltf()
    made.mesh(made.triangles(faces=TRIANGLES[:9]))
    made.mesh(made.triangles(faces=TRIANGLES[9:]))
    return made.file(nodes=[{"children": [1, 2]}, {"mesh": 0}, {"mesh": 1}])


def of_nodes() -> bytes:
    """Turned, scaled and moved by a chain of nodes to where it is."""
    made = Gltf()
    moved = (POINTS - [1.0, 2.0, 3.0])[:, [1, 2, 0]] / 2.0  # undone: scale, turn, move
    made.mesh(made.triangles(moved))
    nodes: list[dict[str, Any]] = [
        {"children": [1], "translation": [1.0, 2.0, 3.0]},
        {"children": [2], "rotation": TURNED},
        {"mesh": 0, "scale": [2.0, 2.0, 2.0]},
    ]
    return made.file(nodes=nodes)


def of_a_matrix() -> bytes:
    made = Gltf()
    made.mesh(made.triangles((POINTS - [1.0, 2.0, 3.0]) / [2.0, 4.0, 8.0]))
    return made.file(nodes=[{"mesh": 0, "matrix": [2, 0, 0, 0, 0, 4, 0, 0, 0, 0, 8, 0, 1, 2, 3, 1]}])


def of_a_mirror() -> bytes:
    made = Gltf()
    made.mesh(made.triangles(POINTS * [-1.0, 1.0, 1.0], np.array(TRIANGLES)[:, ::-1]))
    return made.file(nodes=[{"mesh": 0, "scale": [-1.0, 1.0, 1.0]}])


def of_a_sparse_accessor(dense: bool) -> bytes:
    """Two corners come from the sparse part; without a dense part the others are all at 0, and so is a corner of it."""
    made = Gltf()
    if dense:
        wrong = POINTS.copy()
        wrong[[3, 7]] = 9.0
        places, positions = [3, 7], made.positions(wrong)
    else:
        places, positions = list(range(12)), made.positions(POINTS)
        del made.document["accessors"][positions]["bufferView"]
    made.document["accessors"][positions]["sparse"] = {
        "count": len(places),
        "indices": {"bufferView": made.view(np.array(places, dtype="u1").tobytes()), "componentType": 5121},
        "values": {"bufferView": made.view(POINTS[places].astype("<f4").tobytes())},
    }
    made.mesh({"attributes": {"POSITION": positions}, "indices": made.indices(TRIANGLES)})
    return made.file()


def of_integers(dtype: str, component: int, normalized: bool) -> bytes:
    """Positions in whole numbers, brought to size by the node."""
    made = Gltf()
    most = np.iinfo(np.dtype(dtype)).max
    low, size = POINTS.min(axis=0), np.ptp(POINTS, axis=0).max()
    whole = np.round((POINTS - low) / size * most)
    padded = np.zeros((12, 4))
    padded[:, :3] = whole
    view = made.view(padded.astype(dtype).tobytes(), byteStride=4 * np.dtype(dtype).itemsize)
    accessor = {"bufferView": view, "count": 12, "type": "VEC3", "componentType": component}
    made.document["accessors"].append(accessor | {"normalized": normalized})
    made.mesh({"attributes": {"POSITION": 0}, "indices": made.indices(TRIANGLES)})
    scale = float(size) if normalized else float(size / most)
    node = {"mesh": 0, "translation": low.tolist(), "scale": [scale] * 3}
    return made.file(nodes=[node], extensionsRequired=["KHR_mesh_quantization"])


def of_a_stride(component: int, dtype: str) -> bytes:
    """Positions between other numbers, and indices of another size."""
    made = Gltf()
    mixed = np.full((12, 6), 9.0)
    mixed[:, 2:5] = POINTS
    view = made.view(mixed.astype("<f4").tobytes(), byteStride=24)
    accessor = {"bufferView": view, "byteOffset": 8, "count": 12, "type": "VEC3", "componentType": 5126}
    made.document["accessors"].append(accessor)
    indices = made.accessor(np.array(TRIANGLES).reshape(-1), dtype, "SCALAR", component)
    made.mesh({"attributes": {"POSITION": 0}, "indices": indices})
    return made.file()


def of_morph_targets(where: str) -> bytes:
    made = Gltf()
    move = np.linspace(0.0, 0.3, 36).reshape(12, 3)
    primitive = made.triangles(POINTS - 0.5 * move)
    primitive["targets"] = [{"POSITION": made.positions(9.0 + move)}, {"POSITION": made.positions(move)}]
    weights: dict[str, Any] = {"weights": [0.0, 0.5]}
    made.mesh(primitive, **(weights if where == "mesh" else {"weights": [1.0, 1.0]}))
    return made.file(nodes=[{"mesh": 0} | (weights if where == "node" else {})])


def of_one_instance() -> bytes:
    made = Gltf()
    made.mesh(made.triangles((POINTS[:, [1, 2, 0]] - [1.0, 0.0, 0.0]) / 2.0))
    turned = made.accessor(np.array([TURNED]) * 32767, "<i2", "VEC4", 5122, normalized=True)
    attributes = {"TRANSLATION": made.positions([[0.0, 1.0, 0.0]]), "ROTATION": turned}
    attributes["SCALE"] = made.positions([[2.0, 2.0, 2.0]])
    node = {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}
    return made.file(nodes=[node], extensionsRequired=["EXT_mesh_gpu_instancing"])


def of_data_addresses() -> bytes:
    made = step()
    address = "data:application/octet-stream;base64," + base64.b64encode(made.blob).decode()
    return glb(made.document | {"buffers": [{"byteLength": len(made.blob), "uri": address}]})


def of_another_scene() -> bytes:
    made = step()
    made.mesh(made.triangles(POINTS + 1.0))
    return made.file(nodes=[{"mesh": 1}, {"mesh": 0}], scenes=[{"nodes": [0]}, {"nodes": [1]}], scene=1)


def of_what_is_not_seen() -> bytes:
    """Meshes that no node shows, a hidden node, a camera, an animation, looks: nothing of it is the solid."""
    made = step()
    made.mesh(made.triangles(POINTS + 1.0))
    made.mesh(made.triangles(POINTS + 2.0))
    hidden = {"mesh": 2, "extensions": {"KHR_node_visibility": {"visible": False}}}
    nodes: list[dict[str, Any]] = [{"children": [1, 2, 3]}, {"mesh": 0}, hidden, {"camera": 0}]
    looks = {"materials": [{"name": "steel"}], "cameras": [{"type": "perspective"}], "animations": [{"channels": []}]}
    return made.file(nodes=nodes, extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"], **looks)


def with_draco_beside_it() -> bytes:
    """An extension that is used but not required has the plain numbers beside it."""
    made = step()
    made.document["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    return made.file(extensionsUsed=["KHR_draco_mesh_compression"])


READ: dict[str, Made] = {
    "indices": lambda: step().file(),
    "no indices": of_soup,
    "fans and strips": of_fans,
    "strips with empty triangles": of_strips_with_empty_triangles,
    "two meshes": of_parts,
    "turned, scaled and moved": of_nodes,
    "a matrix": of_a_matrix,
    "a mirror": of_a_mirror,
    "a sparse accessor": lambda: of_a_sparse_accessor(dense=True),
    "a sparse accessor over nothing": lambda: of_a_sparse_accessor(dense=False),
    "small indices between other numbers": lambda: of_a_stride(5121, "u1"),
    "large indices between other numbers": lambda: of_a_stride(5125, "<u4"),
    "a morph target of the mesh": lambda: of_morph_targets("mesh"),
    "a morph target of the node": lambda: of_morph_targets("node"),
    "addresses with data": of_data_addresses,
    "another scene": of_another_scene,
    "one scene that is not named": lambda: glb(
        {k: v for k, v in step().document.items() if k != "scene"} | {"buffers": [{"byteLength": len(step().blob)}]},
        step().blob,
    ),
    "what is not seen": of_what_is_not_seen,
    "Draco beside plain numbers": with_draco_beside_it,
    "bytes behind the file": lambda: step().file() + b"more",
    "a chunk of another kind": lambda: _with_chunk(step().file()),
}


def _with_chunk(content: bytes) -> bytes:
    longer = content + struct.pack("<II", 4, 0x12345678) + b"mine"
    return longer[:8] + struct.pack("<I", len(longer)) + longer[12:]


@pytest.mark.parametrize("made", READ.values(), ids=READ)
def test_every_way_to_write_it_is_the_same_solid(made: Made) -> None:
    assert_solid(read_glb(made()), within=2e-7)


@pytest.mark.parametrize(
    ("dtype", "component", "normalized"),
    [("u1", 5121, True), ("i1", 5120, True), ("<u2", 5123, True), ("<i2", 5122, True), ("<u2", 5123, False)],
)
def test_whole_numbers_are_brought_to_their_size(dtype: str, component: int, normalized: bool) -> None:
    step_size = 0.08 / np.iinfo(np.dtype(dtype)).max
    found = read_glb(of_integers(dtype, component, normalized))
    np.testing.assert_allclose(found.vertices, POINTS, rtol=0.0, atol=step_size)
    assert_solid(found, within=0.2 * step_size + FLOAT32)


def test_the_least_normalised_integer_is_minus_one() -> None:
    made = Gltf()
    made.accessor([[-128, -127, 127]], "i1", "VEC3", 5120, normalized=True)
    made.mesh({"attributes": {"POSITION": 0}, "indices": made.indices([0, 0, 0])})
    assert read_glb(made.file()).vertices.tolist() == [[-1.0, -1.0, 1.0]]


def test_instances_are_copies() -> None:
    assert_solid(read_glb(of_one_instance()), within=1e-5)
    made = step()
    translations = made.positions([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]])
    said = {"attributes": {"TRANSLATION": translations, "_ID": 0}}
    found = read_glb(made.file(nodes=[{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": said}}]))
    assert len(found.faces) == 60
    assert measures(found)[0] == pytest.approx(3.0 * SOLID[0], rel=1e-5)


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


MESHOPT = {"EXT_meshopt_compression": {"buffer": 0, "byteLength": 4}}
REFUSED: dict[str, tuple[Made, str]] = {
    "points": (primitive(mode=0), r"points \(mode 0\) are no surface"),
    "lines": (primitive(mode=1), r"lines \(mode 1\) are no surface"),
    "line strips": (primitive(mode=3), r"line strips \(mode 3\)"),
    "another mode": (primitive(mode=7), "glTF has no mode 7"),
    "no positions": (primitive(attributes={"NORMAL": 0}), "no POSITION"),
    "Draco": (
        file(extensionsRequired=["KHR_draco_mesh_compression"]),
        r"Draco compression \(KHR_draco_mesh_compression\)",
    ),
    "Draco that is not required": (
        changed(
            lambda made: (
                (
                    made.document["meshes"][0]["primitives"][0].update(extensions={"KHR_draco_mesh_compression": {}}),
                    made.document["accessors"][0].pop("bufferView"),
                )
                and None
            )
        ),
        "Draco compression",
    ),
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
    "an external buffer": (file(buffers=[{"byteLength": 9, "uri": "step.bin"}]), "an external buffer, 'step.bin'"),
    "an address": (file(buffers=[{"byteLength": 9, "uri": "http://127.0.0.1/x"}]), "an external buffer, 'http:"),
    "a buffer that is not there": (
        file(buffers=[{"byteLength": 9}, {"byteLength": 9}], bufferViews=[{"buffer": 1, "byteLength": 9}] * 2),
        "buffer 1 has no bytes",
    ),
    "a buffer that is cut off": (file(buffers=[{"byteLength": 10**6}]), "buffer 0 says 1000000 bytes"),
    "a buffer that is not base64": (file(buffers=[{"byteLength": 9, "uri": "data:;base64,***"}]), "not the base64"),
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
    "a node below itself": (file(nodes=[{"mesh": 0, "children": [0]}]), "node 0 is below two nodes, or below itself"),
    "a node below two": (file(nodes=[{"children": [1, 1]}, {"mesh": 0}]), "node 1 is below two nodes"),
    "no such node": (file(scenes=[{"nodes": [5]}]), "it refers to node 5, of 1"),
    "no such mesh": (file(nodes=[{"mesh": 5}]), "it refers to mesh 5, of 1"),
    "no such accessor": (primitive(attributes={"POSITION": 9}), "it refers to accessor 9, of 2"),
    "no such scene": (file(scene=4), "it refers to scene 4, of 1"),
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
        "accessor 2, of 2",
    ),
    "words for numbers": (file(nodes=[{"mesh": "0"}]), "nodes.0.mesh: Input should be a valid integer"),
    "an index below 0": (file(nodes=[{"mesh": -1}]), "nodes.0.mesh: Input should be greater than or equal to 0"),
    "version 1 of glTF": (file(asset={"version": "1.0"}), "expected glTF 2.0, got '1.0'"),
    "a later glTF": (file(asset={"version": "2.1", "minVersion": "2.1"}), "expected glTF 2.0, got '2.1'"),
    "version 1 of GLB": (lambda: b"glTF" + struct.pack("<II", 1, 12), "expected glTF 2, got version 1"),
    "a .gltf file": (lambda: b'{"asset": {"version": "2.0"}}', "a file that begins with 'glTF'"),
    "a file that is cut off": (lambda: step().file()[:-10], "the header says .* bytes, the file has .*: is it cut off"),
    "a chunk that is cut off": (lambda: _short(step().file()), "a chunk says .* is it cut off"),
    "a header alone": (lambda: b"glTF" + struct.pack("<II", 2, 12), "a chunk of JSON first"),
    "less than a header": (lambda: b"glTF", "the header of a GLB file"),
    "JSON that is none": (lambda: glb({}).replace(b"{}", b"{["), "its glTF document is not as expected"),
    "JSON nested without end": (lambda: _nested(), "its glTF document is not as expected"),
}


def _short(content: bytes) -> bytes:
    cut = content[:-10]
    return cut[:8] + struct.pack("<I", len(cut)) + cut[12:]


def _nested() -> bytes:
    text = b'{"asset":' + b"[" * 100_000
    chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunk)) + chunk


@pytest.mark.parametrize(("made", "says"), REFUSED.values(), ids=REFUSED)
def test_what_is_not_supported_is_named(made: Made, says: str) -> None:
    with pytest.raises(Unreadable, match=says) as refused:
        read_glb(made())
    assert "\n" not in str(refused.value)
