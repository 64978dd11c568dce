import math

import numpy as np
import pytest

from tests.voa_core.worlds import UPRIGHT
from voa_core.errors import InvalidInput
from voa_core.geometry import matrices_of_quaternions, turn
from voa_core.poses import PoseSet, generate
from voa_core.stable_poses import StablePose

LYING = StablePose((0.7, 0.8, 0.02), (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0), 0.75)
STANDING = StablePose((0.0, 0.0, 0.05), UPRIGHT, 0.25)


def test_poses_may_be_names_alone() -> None:
    poses = PoseSet.named(["A", "B"])
    assert len(poses) == 2
    assert poses.positions is None
    assert poses.rotations is None


def test_quaternions_are_made_unit() -> None:
    poses = PoseSet.from_arrays(["A"], [[0.0, 0.0, 0.0]], [[0.98, 0.0, 0.0, 0.0]])
    assert poses.quaternions_wxyz is not None
    assert poses.quaternions_wxyz.tolist() == [[1.0, 0.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("names", "positions", "quaternions", "message"),
    [
        (["A", "A"], [[0, 0, 0]] * 2, [UPRIGHT] * 2, "pose: expected names that differ, got 'A' twice"),
        (["A"], [[0, 0, 0]] * 2, [UPRIGHT], "position: expected shape 1x3, got shape 2x3"),
        (["A"], [[0, 0, 0]], [UPRIGHT] * 2, "quaternion_wxyz: expected shape 1x4, got shape 2x4"),
        (["A"], [[0, 0, math.inf]], [UPRIGHT], "position: expected finite numbers"),
        (["A"], [[0, 0, 0]], [[0.0, 0.0, 0.0, 0.0]], "a unit quaternion, got norm 0 at 0"),
    ],
)
def test_poses_that_are_none_are_refused(
    names: list[str], positions: list[list[float]], quaternions: list[list[float]], message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        PoseSet.from_arrays(names, positions, quaternions)


def test_generate_turns_every_stable_pose_about_the_vertical_and_keeps_its_height() -> None:
    poses = generate([LYING, STANDING], [0.0, math.pi / 2], [[0.3, -0.1]])
    assert poses.names == ("S1/0deg", "S1/90deg", "S2/0deg", "S2/90deg")
    assert poses.positions is not None
    assert poses.rotations is not None
    np.testing.assert_allclose(poses.positions, [[0.3, -0.1, 0.02]] * 2 + [[0.3, -0.1, 0.05]] * 2)
    lying = matrices_of_quaternions(np.array([LYING.quaternion_wxyz]))[0]
    np.testing.assert_allclose(poses.rotations[1], turn(math.pi / 2) @ lying, atol=1e-14)
    np.testing.assert_allclose(poses.rotations[3], turn(math.pi / 2), atol=1e-14)


def test_generate_names_places_in_millimetres_where_there_are_several() -> None:
    poses = generate([STANDING], [math.radians(30)], [[0.0, 0.0], [0.01, -0.02]], ["up"])
    assert poses.names == ("up/30deg/0,0", "up/30deg/10,-20")


def test_generate_needs_something_to_generate_from() -> None:
    with pytest.raises(InvalidInput, match="at least one stable pose, yaw and position"):
        generate([], [0.0], [[0.0, 0.0]])
    with pytest.raises(InvalidInput, match="at least one stable pose, yaw and position"):
        generate([STANDING], [], [[0.0, 0.0]])


def test_generate_refuses_two_poses_of_one_name() -> None:
    with pytest.raises(InvalidInput, match="'S1/0deg' twice"):
        generate([STANDING], [0.0, 0.0], [[0.0, 0.0]])


def test_generate_refuses_other_than_one_name_per_stable_pose() -> None:
    with pytest.raises(InvalidInput, match="names: expected one per stable pose, 2, got 1"):
        generate([STANDING, LYING], [0.0], [[0.0, 0.0]], ["up"])


def test_some_of_the_poses_are_a_set_of_their_own() -> None:
    poses = PoseSet.from_arrays(["A", "B", "C"], [[0.0, 0.0, float(i)] for i in range(3)], [[1.0, 0.0, 0.0, 0.0]] * 3)
    some = poses.subset(np.array([2, 0]))
    assert some.names == ("C", "A")
    assert some.positions is not None
    assert some.positions[:, 2].tolist() == [2.0, 0.0]
    assert PoseSet.named(["A", "B"]).subset(np.array([1])).names == ("B",)
