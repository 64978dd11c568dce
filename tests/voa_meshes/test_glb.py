"""GLB: every way to write a scene of triangles gives the solid where it is; what is not supported is named."""

import base64
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.voa_meshes.files import POINTS, SOLID, TRIANGLES, Gltf, assert_solid, glb, measures, step
from voa_meshes.glb import read_glb

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
    mesh = read_glb(of_integers(dtype, component, normalized))
    np.testing.assert_allclose(mesh.vertices, POINTS, rtol=0.0, atol=step_size)
    assert_solid(mesh, within=0.2 * step_size + FLOAT32)


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
    mesh = read_glb(made.file(nodes=[{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": said}}]))
    assert len(mesh.faces) == 60
    assert measures(mesh)[0] == pytest.approx(3.0 * SOLID[0], rel=1e-5)
