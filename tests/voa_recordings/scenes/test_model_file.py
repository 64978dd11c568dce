"""Models of a mesh at several poses, as trimesh reads them."""

import io
import math
import struct
from typing import Any

import numpy as np
import pytest
import trimesh

from voa_recordings.scenes.model_file import indexed_mesh, model_of
from voa_scene.colours import GREY, ORANGE
from voa_scene.rotations import about_z
from voa_scene.shapes import MeshShape

BOX = trimesh.creation.box(extents=(0.3, 0.1, 0.05))
STL: bytes = BOX.export(file_type="stl")
Z_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Rotation that a viewer with z up gives to every glTF file."""
COPIES = [
    MeshShape(group="belief", name="A", position=(1.0, 2.0, 3.0), colour=ORANGE.faded(0.7), object="o"),
    MeshShape(group="belief", name="B", rotation=about_z(math.pi / 2.0), colour=GREY.faded(0.2), object="o"),
]


def shown(data: bytes) -> Any:
    """Read a GLB file as a viewer with z up does."""
    scene: Any = trimesh.load(io.BytesIO(data), file_type="glb", force="scene")
    return scene.apply_transform(Z_UP)


def test_each_copy_stands_at_its_pose() -> None:
    scene = shown(model_of(indexed_mesh(STL), COPIES))
    bounds = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        bounds[node] = scene.geometry[geometry].copy().apply_transform(transform).bounds
    assert sorted(bounds) == ["A", "B"]
    np.testing.assert_allclose(bounds["A"], np.array([1.0, 2.0, 3.0]) + BOX.bounds, atol=1e-6)
    np.testing.assert_allclose(bounds["B"], [[-0.05, -0.15, -0.025], [0.05, 0.15, 0.025]], atol=1e-6)


def test_the_opacity_of_each_copy_is_that_of_its_shape() -> None:
    scene = shown(model_of(indexed_mesh(STL), COPIES))
    opacities = {
        node: scene.geometry[scene.graph[node][1]].visual.material.baseColorFactor[3] / 255.0
        for node in scene.graph.nodes_geometry
    }
    assert opacities == pytest.approx({"A": 0.7, "B": 0.2}, abs=0.005)


def test_the_mesh_is_in_the_file_once_whatever_the_number_of_copies() -> None:
    mesh = indexed_mesh(STL)
    assert (len(mesh.vertices), len(mesh.indices)) == (8 * 12, 12 * 3 * 4)
    for copies in (COPIES[:1], COPIES * 30):
        data = model_of(mesh, copies)
        assert data.count(mesh.vertices) == 1
        assert struct.unpack_from("<4sII", data) == (b"glTF", 2, len(data))


@pytest.mark.parametrize("stl", [b"", b"solid x\n" * 20, STL[:-1], STL[:80] + struct.pack("<I", 99) + STL[84:]])
def test_a_file_that_is_no_binary_stl_is_refused(stl: bytes) -> None:
    with pytest.raises(ValueError, match="expected a binary STL file"):
        indexed_mesh(stl)
