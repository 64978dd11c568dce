"""Objects are read whole or refused with what is wrong."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.mesh_shapes import box
from voa_assets import path
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.frames import angle_between, matrix_of
from voa_fleet.world.meshes import Mesh, encloses_volume, read_groups, read_obj, volume_of
from voa_fleet.world.objects import OBJECTS, FleetObject, named_object, read_object
from voa_setup.hulls import collision_solids, write_hulls

GRASPS = ("TD0", "TD90", "OI90", "TDH0")
TIP = {"tip": [0, 0, 0], "approach": [0, 0, -1], "closing": [1, 0, 0]}
PARALLEL = {"tool_centre_point": [0, 0, 0], "approach": [0, 0, -1], "closing": [0, 0, 1]}


def changed(folder: Path, file: str, **changes: Any) -> Path:
    """A copy of the mug's folder with a changed file."""
    shutil.copytree(path("mug"), folder)
    body = json.loads((folder / file).read_text(encoding="utf-8")) | changes
    (folder / file).write_text(json.dumps(body), encoding="utf-8")
    return folder


@pytest.mark.parametrize("name", OBJECTS)
def test_the_project_s_objects_are_read(name: str) -> None:
    target = named_object(name)
    assert target.name == name
    assert list(target.geometries) == target.grasps
    assert target.mesh.faces.max() == len(target.mesh.vertices) - 1


@pytest.mark.parametrize("name", OBJECTS)
def test_every_pose_points_up_as_its_way_to_rest_says(targets: dict[str, FleetObject], name: str) -> None:
    target = targets[name]
    for rest in target.physics.rests.values():
        for pose in rest.poses:
            up = matrix_of(target.pose(pose).quaternion_wxyz or [])[2]
            directions = [np.array(own) / np.linalg.norm(own) for own in rest.ups]
            assert min(angle_between(up, direction) for direction in directions) < 0.01


def test_a_folder_of_one_s_own_is_an_object(tmp_path: Path) -> None:
    folder = changed(tmp_path / "own", "scenario.json", name="my mug")
    assert named_object(str(folder)).name == "my mug"


def test_an_object_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(
        UnknownName, match="no object 'teapot'; there are: mug, mallet, block, goblet, coupling, a folder"
    ):
        named_object("teapot")


def test_poses_and_grasps_that_do_not_exist_are_refused(mug: FleetObject) -> None:
    with pytest.raises(UnknownName, match="no pose 'X'; there are: U_0, U_90"):
        mug.pose("X")
    with pytest.raises(UnknownName, match="no grasp 'X'; there are: TD0, TD90, OI90, TDH0"):
        mug.grasp("X")


@pytest.mark.parametrize(
    ("file", "changes", "message"),
    [
        ("physics.json", {"density_kg_m3": -1.0}, "density_kg_m3"),
        (
            "physics.json",
            {"grasps": {"X": TIP}},
            "expected grasps",
        ),
        ("physics.json", {"rests": {"flat": {"poses": ["U_0"], "ups": [[0, 0, 1]]}}}, "under exactly one of `rests`"),
        ("physics.json", {"colour": "red"}, "colour"),
        ("physics.json", {"solids": [{"kind": "hulls", "file": "absent.obj"}]}, "absent.obj"),
        ("physics.json", {"solids": [{"kind": "hulls", "file": "../../etc/passwd"}]}, "a file in this folder"),
        ("scenario.json", {"object": "../mug/mug.obj"}, "a file in this folder"),
        ("scenario.json", {"grasps": [{"name": name} for name in GRASPS]}, "grasp 'TD0' has no geometry"),
        ("scenario.json", {"grasps": [{"name": name, "data": PARALLEL} for name in GRASPS]}, "perpendicular"),
        ("scenario.json", {"object": None}, "mesh's file name"),
        ("scenario.json", {"object": "absent.obj"}, "absent.obj"),
        ("scenario.json", {"lidar": {"preset": "lds-01"}}, "lidar.height_m"),
    ],
)
def test_a_folder_that_is_no_object_is_refused(
    tmp_path: Path, file: str, changes: dict[str, Any], message: str
) -> None:
    folder = changed(tmp_path / "wrong", file, **changes)
    with pytest.raises(InvalidObject, match=message):
        read_object(folder)


def test_a_grasp_s_geometry_is_its_data_unless_physics_states_it(tmp_path: Path) -> None:
    oblique = {"tip": [0.1, 0.2, 0.3], "approach": [0, 0, -2], "closing": [1, 0, 1]}
    target = read_object(changed(tmp_path / "mug", "physics.json", grasps={"TD90": oblique}))
    assert target.grasp("TD0").tool_centre_point == (0.038, 0.0, 0.068)
    assert target.grasp("TD90").tool_centre_point == (0.1, 0.2, 0.3)
    assert target.grasp("TD90").closing == (1.0, 0.0, 0.0)


def test_convex_pieces_are_read_from_the_folder(tmp_path: Path) -> None:
    solids = [solid.model_dump(mode="json") for solid in collision_solids("pieces.obj")]
    folder = changed(tmp_path / "mug", "physics.json", solids=solids)
    pieces = [box(0.02, 0.03, 0.04), box(0.05, 0.01, 0.01)]
    write_hulls(folder / "pieces.obj", pieces)
    target = read_object(folder)
    volumes = [volume_of(piece) for piece in target.hulls["pieces.obj"]]
    assert volumes == pytest.approx([0.02 * 0.03 * 0.04, 0.05 * 0.01 * 0.01])
    assert target.with_opening(0.05).hulls is target.hulls


FLAT = "o piece\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4\nf 1 4 3\nf 1 4 2\nf 1 3 4\n"


def test_a_flat_piece_is_refused(tmp_path: Path) -> None:
    folder = changed(tmp_path / "mug", "physics.json", solids=[{"kind": "hulls", "file": "hulls.obj"}])
    (folder / "hulls.obj").write_text(FLAT, encoding="utf-8")
    with pytest.raises(InvalidObject, match="expected pieces that have volume, got a flat one: number 0"):
        read_object(folder)


def test_each_group_of_an_obj_file_is_a_mesh(tmp_path: Path) -> None:
    file = tmp_path / "two.obj"
    file.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\ng empty\no first\nf 1 2 3\no second\nv 0 0 1\nf 2 3 -1\nf 2 -1 1\n",
        encoding="utf-8",
    )
    first, second = read_groups(file)
    assert (len(first.vertices), first.faces.tolist()) == (3, [[0, 1, 2]])
    assert (len(second.vertices), second.faces.tolist()) == (4, [[1, 2, 3], [1, 3, 0]])
    assert read_obj(file).faces.shape == (3, 3)


def test_a_closed_mesh_encloses_a_volume_an_open_or_a_flat_one_none(mug: FleetObject) -> None:
    assert encloses_volume(mug.mesh)
    assert volume_of(mug.mesh) == pytest.approx(1.1428e-4, rel=1e-3)
    assert not encloses_volume(Mesh(mug.mesh.vertices, mug.mesh.faces[1:]))
    assert not encloses_volume(Mesh(mug.mesh.vertices * [1.0, 1.0, 0.0], mug.mesh.faces))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidObject, match=r"scenario\.json"):
        read_object(tmp_path)


def test_the_gripper_can_open_differently(mug: FleetObject) -> None:
    assert mug.with_opening(0.085).physics.gripper.opening_m == 0.085
    assert mug.physics.gripper.opening_m == 0.018
    with pytest.raises(InvalidObject, match="opening_m"):
        mug.with_opening(0.5)


def test_obj_files_may_have_polygons_and_relative_indices(tmp_path: Path) -> None:
    file = tmp_path / "square.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1/1 2/2 3/3 -1\n", encoding="utf-8")
    mesh = read_obj(file)
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


ARROW = "v 0 0 0\nv 2 1 0\nv 0 2 0\nv 0.5 1 0\n"


@pytest.mark.parametrize(
    "text",
    ["", "v 0 0\nf 1 1 1\n", "v 0 0 zero\n", "v 0 0 0\nf 1 2 3\n", f"{ARROW}f 0 1 2\n", f"{ARROW}f 1 2 3 4\n"],
)
def test_a_file_without_a_mesh_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "wrong.obj"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidObject, match=r"wrong\.obj"):
        read_obj(file)
