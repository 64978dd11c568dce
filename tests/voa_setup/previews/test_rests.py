"""Preview of the rests: those of the scenario, with a picture each."""

from pathlib import Path

import pytest

from tests.support.meshes import box, setup_mesh, stable_poses
from voa_setup.poses import make_poses
from voa_setup.previews.rests import preview_rests


def test_the_rests_are_those_of_the_poses_and_have_pictures(tmp_path: Path) -> None:
    mesh = setup_mesh(box(0.10, 0.05, 0.03), tmp_path)
    stable = stable_poses(mesh)
    preview = preview_rests(mesh, stable, tmp_path)
    poses = make_poses(mesh, stable, yaws_deg=(0.0,))
    assert [rest.name for rest in preview.rests] == list(poses.rests)
    assert sum(rest.probability for rest in preview.rests) == pytest.approx(1.0)
    assert [rest.alike for rest in preview.rests] == [2, 2, 2]
    assert all((tmp_path / str(name)).is_file() for rest in preview.rests for name in (rest.picture, rest.side))
    left, right, bottom, top = preview.rests[0].side_m
    assert (right - left, top - bottom) == pytest.approx((0.10, 0.03), abs=0.003)
    assert bottom == pytest.approx(0.0, abs=0.002)
    assert preview.size_m == pytest.approx((0.10, 0.05, 0.03))
