import numpy as np
import pytest

from voa_msgs.scenarios import Pose
from voa_setup.motions import matrices_of_poses, matrix_of_pose

QUARTER = Pose(name="quarter", position=[0.1, 0.2, 0.3], quaternion_wxyz=[0.5**0.5, 0.0, 0.0, 0.5**0.5])


def test_a_pose_turns_and_then_moves() -> None:
    moved = matrix_of_pose(QUARTER) @ [1.0, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(moved, [0.1, 1.2, 0.3, 1.0], rtol=0.0, atol=1e-12)


def test_many_poses_are_as_each_alone() -> None:
    matrices = matrices_of_poses([QUARTER, QUARTER])
    assert matrices.shape == (2, 4, 4)
    assert (matrices[1] == matrix_of_pose(QUARTER)).all()
    assert matrices_of_poses([]).shape == (0, 4, 4)


@pytest.mark.parametrize("missing", ["position", "quaternion_wxyz"])
def test_a_pose_without_geometry_is_refused(missing: str) -> None:
    with pytest.raises(ValueError, match="'quarter'"):
        matrix_of_pose(QUARTER.model_copy(update={missing: None}))
