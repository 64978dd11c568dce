"""Objects are read whole or refused with what is wrong."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from voa_assets import path
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.frames import angle_between, matrix_of
from voa_fleet.world.meshes import read_obj
from voa_fleet.world.objects import OBJECTS, FleetObject, named_object, read_object


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
    assert set(target.physics.grasps) == set(target.grasps)
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
        ("physics.json", {"grasps": {}}, "expected grasps"),
        ("physics.json", {"rests": {"flat": {"poses": ["U_0"], "ups": [[0, 0, 1]]}}}, "under exactly one of `rests`"),
        ("physics.json", {"colour": "red"}, "colour"),
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
