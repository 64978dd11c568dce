"""Meshes read from files: unit, axis, centre of mass, and reasons why a mesh cannot be used."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.support.meshes import box, cylinder, joined, moved, mug, written
from voa_fleet.world.meshes import read_obj
from voa_setup.errors import UnlikelySize, UnusableMesh
from voa_setup.mesh import MOST_FACES, read_mesh, write_mesh


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off"])
def test_every_type_of_file_gives_one_mesh_about_its_centre_of_mass(tmp_path: Path, ending: str) -> None:
    part = box(0.12, 0.04, 0.08)
    part.apply_translation([1.0, 2.0, 3.0])
    mesh = read_mesh(written(part, tmp_path / f"part.{ending}"))
    assert mesh.name == "part"
    assert mesh.watertight
    np.testing.assert_allclose(mesh.extents, [0.12, 0.04, 0.08], atol=1e-6)
    np.testing.assert_allclose(mesh.mesh.vertices.min(axis=0), [-0.06, -0.02, -0.04], atol=1e-6)
    assert (len(mesh.mesh.vertices), len(mesh.mesh.faces)) == (8, 12)


def test_a_glb_file_has_y_up_by_its_standard_and_other_files_where_stated(tmp_path: Path) -> None:
    assert read_mesh(written(box(0.1, 0.3, 0.2), tmp_path / "b.glb")).extents == pytest.approx([0.1, 0.2, 0.3])
    stl = written(box(0.1, 0.3, 0.2), tmp_path / "b.stl")
    assert read_mesh(stl, up="+Y").extents == pytest.approx([0.1, 0.2, 0.3])
    assert read_mesh(stl).extents == pytest.approx([0.1, 0.3, 0.2])


@pytest.mark.parametrize(("size", "scales"), [(95.0, (0.001,)), (4.0, (0.0254, 0.01)), (1e-4, ()), (5000.0, ())])
def test_an_unlikely_size_is_refused_with_the_scales_that_would_explain_it(
    tmp_path: Path, size: float, scales: tuple[float, ...]
) -> None:
    file = written(box(size, size / 2, size / 3), tmp_path / "part.stl")
    with pytest.raises(UnlikelySize) as refusal:
        read_mesh(file)
    assert refusal.value.scales == scales
    for scale in scales:
        assert f"--scale {scale:g} if it is in" in str(refusal.value)
        assert read_mesh(file, scale=scale).extents.max() == pytest.approx(size * scale, rel=1e-4)


def test_an_open_mesh_works_and_the_note_says_what_is_guessed(tmp_path: Path) -> None:
    can = cylinder(0.03, 0.1)
    can.update_faces(np.abs(can.triangles_center[:, 2] - 0.05) > 1e-6)  # without its lid
    mesh = read_mesh(written(can, tmp_path / "can.stl"))
    assert not mesh.watertight
    assert "The mesh is not closed (32 of its edges" in mesh.notes[0]
    np.testing.assert_allclose(mesh.mesh.vertices[:, 2].min(), -0.05, atol=1e-6)  # of the hull, which has the lid


def test_separate_bodies_are_noted_and_cavities_are_not(tmp_path: Path) -> None:
    plate = box(0.3, 0.3, 0.01)
    plate.apply_translation([0.0, 0.0, -0.1])
    two = read_mesh(written(joined(box(0.1, 0.1, 0.1), plate), tmp_path / "two.stl"))
    assert "consists of 2 separate bodies" in two.notes[0]
    cavity = box(0.05, 0.05, 0.05)
    cavity.invert()
    hollow = joined(box(0.1, 0.1, 0.1), cavity)
    assert read_mesh(written(hollow, tmp_path / "hollow.stl")).notes == ()
    assert read_mesh(written(box(0.1, 0.1, 0.1), tmp_path / "one.stl")).notes == ()


def test_a_mesh_of_faces_turned_inside_out_is_turned_right(tmp_path: Path) -> None:
    turned = box(0.1, 0.1, 0.1)
    turned.faces = turned.faces[:, ::-1]
    mesh = read_mesh(written(turned, tmp_path / "b.obj"))
    assert trimesh.Trimesh(mesh.mesh.vertices, mesh.mesh.faces, process=False).volume == pytest.approx(1e-3)


def test_what_cannot_become_an_object_is_refused_with_the_reason(tmp_path: Path) -> None:
    sheet = box(0.1, 0.1, 1e-8)
    dense = trimesh.creation.icosphere(7, 0.03)
    assert len(dense.faces) > MOST_FACES
    (tmp_path / "text.stl").write_text("solid of nothing")
    (tmp_path / "point.step").write_text("x")
    for file, words in {
        written(sheet, tmp_path / "sheet.stl"): "is flat",
        written(dense, tmp_path / "dense.ply"): "simplify it",
        tmp_path / "text.stl": "text.stl",
        tmp_path / "point.step": "expected a mesh file that ends with stl, obj",
        tmp_path / "none.stl": "no such file",
    }.items():
        with pytest.raises(UnusableMesh, match=words):
            read_mesh(file)


def test_a_written_mesh_is_read_back_as_it_was(tmp_path: Path) -> None:
    part = mug()
    part.apply_transform(moved(0.3, 0.1, 0.0))
    mesh = read_mesh(written(part, tmp_path / "mug.stl"))
    write_mesh(mesh.mesh, tmp_path / "out.obj")
    again = read_obj(tmp_path / "out.obj")
    np.testing.assert_array_equal(again.vertices, mesh.mesh.vertices)
    np.testing.assert_array_equal(again.faces, mesh.mesh.faces)
