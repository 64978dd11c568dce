"""Outlines in the scan plane: where a lidar sees the object, and nothing where the plane misses it."""

import numpy as np
import pytest

from tests.voa_setup.look.scenes import ON_ITS_SIDE, UPRIGHT, box, mug
from voa_msgs.scenarios import Pose
from voa_setup.look.outlines import outlines, placed

AT = [0.1, 0.2, 0.0]


def pose(quaternion: list[float], position: list[float], name: str = "P") -> Pose:
    return Pose.model_validate({"name": name, "position": position, "quaternion_wxyz": quaternion})


def test_a_box_is_cut_to_a_rectangle_in_the_world() -> None:
    upright, lying = outlines(box(), [pose(UPRIGHT, AT), pose(ON_ITS_SIDE, [0.0, 0.0, 0.03], "Q")], 0.02)
    corners = upright.reshape(-1, 2)
    assert (corners.min(axis=0), corners.max(axis=0)) == (pytest.approx([0.08, 0.17]), pytest.approx([0.12, 0.23]))
    lengths = np.linalg.norm(upright[:, 1] - upright[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(2 * (0.04 + 0.06))
    corners = lying.reshape(-1, 2)
    assert np.ptp(corners, axis=0) == pytest.approx([0.04, 0.05])


def test_a_plane_above_the_box_sees_nothing() -> None:
    (nothing,) = outlines(box(), [pose(UPRIGHT, AT)], 0.06)
    assert nothing.shape == (0, 2, 2)


def test_the_inside_of_the_mug_is_not_seen() -> None:
    scenario, mesh = mug()
    first = outlines(mesh, scenario.poses, 0.05)[0].reshape(-1, 2)
    radius = np.hypot(*first.T)
    assert radius.min() > 0.0395  # the outer wall and the handle; the inner wall has 36 mm
    assert radius.max() == pytest.approx(0.0715, abs=0.001)


def test_a_placed_mesh_stands_where_its_pose_says() -> None:
    lying = placed(box(), pose(ON_ITS_SIDE, [0.0, 0.0, 0.03]))
    assert (lying.vertices.min(axis=0), lying.vertices.max(axis=0)) == (
        pytest.approx([-0.02, -0.05, 0.0], abs=1e-12),
        pytest.approx([0.02, 0.0, 0.06], abs=1e-12),
    )
