"""Convex pieces of any mesh: near its shape, convex, equal for equal meshes, and never a crash."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tests.support.mesh_shapes import angle, bowl, box, open_box, sheet, soup
from voa_assets import path
from voa_fleet.errors import InvalidObject
from voa_fleet.world.meshes import Mesh, read_obj, volume_of
from voa_setup.hulls import FILE, collision_solids, convex_pieces, describe_pieces, is_closed, read_hulls, write_hulls


def volume(pieces: list[Mesh]) -> float:
    return sum(volume_of(piece) for piece in pieces)


def test_a_convex_mesh_is_one_piece() -> None:
    mesh = box(0.05, 0.03, 0.02)
    (piece,) = convex_pieces(mesh)
    assert volume_of(piece) == pytest.approx(0.05 * 0.03 * 0.02)


def test_an_angle_is_two_boxes() -> None:
    pieces = convex_pieces(angle())
    assert len(pieces) == 2
    assert volume(pieces) == pytest.approx(volume_of(angle()), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "excess", "most"), [("goblet", 0.005, 15), ("mallet", 0.005, 5), ("coupling", 0.005, 25)]
)
def test_pieces_of_a_shipped_object_fill_its_mesh_and_hardly_more(name: str, excess: float, most: int) -> None:
    mesh = read_obj(path(name) / f"{name}.obj")
    pieces = convex_pieces(mesh)
    assert len(pieces) <= most
    assert 1.0 - 1e-6 <= volume(pieces) / volume_of(mesh) <= 1.0 + excess


def test_the_wall_of_a_bowl_keeps_its_thickness() -> None:
    mesh = bowl()
    pieces = convex_pieces(mesh)
    assert volume(pieces) / volume_of(mesh) == pytest.approx(1.0, abs=0.03)
    # 1.5 mm inside the wall's middle line is a piece, the hollow is none.
    wall, hollow = np.array([0.0535, 0.0, 0.032]), np.array([0.0, 0.0, 0.02])
    assert any(_holds(piece, wall) for piece in pieces)
    assert not any(_holds(piece, hollow) for piece in pieces)


def _holds(piece: Mesh, point: np.ndarray) -> bool:
    equations = ConvexHull(piece.vertices).equations
    return bool((equations[:, :3] @ point + equations[:, 3] <= 1e-9).all())


@pytest.mark.parametrize("make", [angle, bowl, open_box])
def test_every_piece_is_convex_and_has_volume(make: object) -> None:
    assert callable(make)
    for piece in convex_pieces(make()):
        assert volume_of(piece) > 1e-11
        assert volume_of(piece) == pytest.approx(ConvexHull(piece.vertices).volume, rel=1e-6)


def test_a_surface_that_is_not_closed_becomes_a_shell() -> None:
    mesh = open_box()
    pieces = convex_pieces(mesh)
    assert not is_closed(mesh)
    area = 2 * 0.06 * 0.10 + 2 * 0.04 * 0.10 + 0.06 * 0.04
    assert volume(pieces) == pytest.approx(area * 0.001, rel=0.05)
    assert "shell 1 mm thick" in describe_pieces(mesh, pieces)


def test_a_sheet_becomes_a_plate() -> None:
    (piece,) = convex_pieces(sheet())
    assert volume_of(piece) == pytest.approx(0.1 * 0.06 * 0.001)
    assert describe_pieces(sheet(), [piece]).endswith("of 1 convex piece")


def test_a_mesh_whose_faces_share_no_vertices_is_closed_nevertheless() -> None:
    assert is_closed(soup(angle()))
    assert len(convex_pieces(soup(angle()))) == 2


def test_a_mesh_that_is_turned_inside_out_is_turned_back() -> None:
    mesh = angle()
    assert len(convex_pieces(Mesh(mesh.vertices, mesh.faces[:, ::-1].copy()))) == 2


def test_a_mesh_without_area_is_refused() -> None:
    line = Mesh(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.array([[0, 1, 2]], dtype=np.int32))
    with pytest.raises(InvalidObject, match="expected faces with an area"):
        convex_pieces(line)


def test_the_number_of_pieces_is_bounded() -> None:
    assert len(convex_pieces(bowl(), most=10)) <= 12


def test_pieces_are_written_and_read_and_equal_meshes_give_equal_files(tmp_path: Path) -> None:
    first, second = tmp_path / "first.obj", tmp_path / "second.obj"
    pieces = convex_pieces(bowl())
    write_hulls(first, pieces)
    write_hulls(second, convex_pieces(bowl()))
    assert first.read_bytes() == second.read_bytes()
    back = read_hulls(first)
    assert [len(piece.faces) for piece in back] == [len(piece.faces) for piece in pieces]
    assert np.abs(np.concatenate([a.vertices - b.vertices for a, b in zip(back, pieces, strict=True)])).max() < 1e-7


def test_the_gripper_meets_the_pieces_and_the_table_the_hull() -> None:
    hull, pieces = (solid.model_dump() for solid in collision_solids())
    assert hull == {"kind": "hull", "touches": "table"}
    assert pieces == {"kind": "hulls", "file": FILE, "touches": "gripper"}
