"""Poses from rests, yaws and positions: names, twins, prior, and where the object lies."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.support.meshes import box, cylinder, joined, mug, setup_mesh, stable_poses
from voa_setup.errors import InvalidOption
from voa_setup.motions import matrices_of_poses
from voa_setup.poses import PoseSet, even_yaws, make_poses


def poses_of(part: trimesh.Trimesh, folder: Path, **options: object) -> PoseSet:
    mesh = setup_mesh(part, folder)
    return make_poses(mesh, stable_poses(mesh), **({"yaws_deg": even_yaws(8)} | options))  # type: ignore[arg-type] # fields of several types


def names(poses: PoseSet) -> list[str]:
    return [pose.name for pose in poses.poses]


def test_a_box_has_three_rests_at_four_yaws(tmp_path: Path) -> None:
    result = poses_of(box(0.10, 0.05, 0.03), tmp_path)
    assert names(result) == [
        f"{rest} {yaw}" for rest in ("upright", "on side A", "on side B") for yaw in (0, 45, 90, 135)
    ]
    assert "'upright' stands for 2 rests that look the same." in result.merged
    assert any(sentence.startswith("'upright' looks the same at several yaws: 0 for 180") for sentence in result.merged)
    assert sum(result.prior) == pytest.approx(1.0, abs=1e-6)
    assert len(set(result.prior)) == 3
    assert result.prior[0] > result.prior[4] > result.prior[8]
    assert set(result.rests["upright"].ups) == {(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)}
    assert result.rests["upright"].poses == names(result)[:4]


def test_a_solid_of_revolution_has_one_upright_pose(tmp_path: Path) -> None:
    result = poses_of(cylinder(0.03, 0.1), tmp_path)
    assert names(result) == [*(f"on side A {yaw}" for yaw in (0, 45, 90, 135)), "upright"]
    assert "'upright' looks the same at all 8 yaws: one pose stands for them." in result.merged


def test_a_handle_makes_every_yaw_another_pose(tmp_path: Path) -> None:
    result = poses_of(mug(), tmp_path)
    for rest in ("upright", "upside down", "on side A", "on side B"):
        assert [name for name in names(result) if name.startswith(rest)] == [f"{rest} {45 * k}" for k in range(8)]
    assert result.merged == []


def test_a_ball_has_one_pose(tmp_path: Path) -> None:
    result = poses_of(trimesh.creation.icosphere(4, 0.03), tmp_path)
    assert names(result) == ["resting"]
    assert result.prior == [1.0]


def test_the_centre_of_mass_lies_over_the_position_at_every_yaw_and_the_object_on_the_table(tmp_path: Path) -> None:
    part = mug()
    part.apply_translation([0.4, -0.2, 0.1])
    mesh = setup_mesh(part, tmp_path)
    positions = [(0.05, 0.0), (-0.05, 0.02)]
    result = make_poses(mesh, stable_poses(mesh), yaws_deg=[0.0, 30.0], positions=positions)
    assert "upright 30 at -0.05,0.02" in names(result)
    transforms = matrices_of_poses(result.poses)
    np.testing.assert_allclose(
        transforms[:, :2, 3], [where for _ in result.rests for where in positions for _ in (0, 30)], atol=2e-6
    )
    for transform in transforms:
        placed = mesh.mesh.vertices @ transform[:3, :3].T + transform[:3, 3]
        assert abs(placed[:, 2].min()) < 1e-5


def test_yaw_0_points_the_mesh_where_its_name_says(tmp_path: Path) -> None:
    result = poses_of(mug(), tmp_path)
    for pose, transform in zip(result.poses, matrices_of_poses(result.poses), strict=True):
        yaw = np.radians(float(pose.name.split()[-1]))
        axis = 0 if pose.name.startswith("up") else 2  # the mesh's x axis, or its z axis where it lies
        along = transform[:2, axis] / np.linalg.norm(transform[:2, axis])
        np.testing.assert_allclose(along, [np.cos(yaw), np.sin(yaw)], atol=1e-6)


def test_improbable_rests_are_left_out_and_named(tmp_path: Path) -> None:
    result = poses_of(box(0.10, 0.05, 0.03), tmp_path, least_probability=0.2)
    assert {name.rsplit(" ", 1)[0] for name in names(result)} == {"upright", "on side A"}
    assert result.left_out == ["'on side B' is left out: the object comes to rest that way with probability 0.082."]
    assert result.rests["on side B"].poses == []
    assert sum(result.prior) == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(InvalidOption, match=r"the most probable, 'upright', has 0\.61"):
        poses_of(box(0.10, 0.05, 0.03), tmp_path, least_probability=0.7)


def test_a_feature_of_two_millimetres_keeps_poses_apart_and_one_of_a_tenth_does_not(tmp_path: Path) -> None:
    body = cylinder(0.03, 0.1)
    for size, upright in ((0.002, 8), (0.0001, 1)):
        rib = box(size, 0.006, 0.08)
        rib.apply_translation([0.03 + size / 2, 0.0, 0.0])
        result = poses_of(joined(body, rib), tmp_path, least_probability=0.0)
        assert sum(name.startswith("upright") for name in names(result)) == upright


def test_rests_are_kept_by_name_however_probable(tmp_path: Path) -> None:
    result = poses_of(box(0.10, 0.05, 0.03), tmp_path, rests=("on side B",), least_probability=0.9)
    assert {name.rsplit(" ", 1)[0] for name in names(result)} == {"on side B"}
    assert sum(result.prior) == pytest.approx(1.0)
    assert result.rests["upright"].poses == []
    assert any(sentence.startswith("'upright' is left out") for sentence in result.left_out)
    with pytest.raises(InvalidOption, match="--rests: there is no rest 'flying'; there are: 'upright', 'on side A'"):
        poses_of(box(0.10, 0.05, 0.03), tmp_path, rests=("flying",))
    with pytest.raises(InvalidOption, match="expected at least one rest"):
        poses_of(box(0.10, 0.05, 0.03), tmp_path, rests=())
