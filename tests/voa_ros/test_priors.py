import math

import numpy as np
import pytest

from voa_msgs.scenarios import Pose
from voa_ros import messages
from voa_ros.messages import PoseWithCovariance, Stamp
from voa_ros.priors import UnusablePrior, marked_belief, yaw_of
from voa_ros.robots import RobotMapping, load

HALF = math.sqrt(0.5)


def mapped(place: str = '{ from = "attachment" }') -> RobotMapping:
    return load(f'[[robot]]\nname = "tb3_1"\nsession = "s"\nplace = {place}\n')[0]


def listed(x: float, y: float, yaw: float) -> Pose:
    quaternion = [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]
    return Pose(name=f"{x} {y} {yaw}", position=[x, y, 0.0], quaternion_wxyz=quaternion)


def marked(x: float, y: float, yaw: float, covariance: np.ndarray, frame: str = "world") -> PoseWithCovariance:
    whole = np.zeros((6, 6))
    whole[np.ix_([0, 1, 5], [0, 1, 5])] = covariance
    return PoseWithCovariance(Stamp(), frame, messages.Pose.planar(x, y, yaw), tuple(whole.ravel().tolist()))


COVARIANCE = np.array([[0.01, 0.004, 0.002], [0.004, 0.02, -0.003], [0.002, -0.003, 0.05]])
POSES = [listed(0.1, 0.0, 0.2), listed(-0.05, 0.1, 3.1), listed(0.0, 0.0, -0.4)]


def density(differences: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    inverse = np.linalg.inv(covariance + np.diag([1e-6, 1e-6, 1e-5]))
    weights = np.exp(-np.einsum("ij,jk,ik->i", differences, inverse, differences) / 2)
    return np.asarray(weights / weights.sum())


def test_weights_are_those_of_the_normal_distribution_times_the_prior() -> None:
    prior = [0.5, 0.2, 0.3]
    belief = marked_belief(POSES, prior, marked(0.02, 0.01, 0.1, COVARIANCE), mapped())
    differences = np.array([[0.08, -0.01, 0.1], [-0.07, 0.09, 3.0], [-0.02, -0.01, -0.5]])
    weights = density(differences, COVARIANCE) * prior
    assert belief == pytest.approx(weights / weights.sum(), rel=1e-9)


def test_a_difference_of_yaw_is_the_shorter_way_round() -> None:
    belief = marked_belief([listed(0, 0, 3.1), listed(0, 0, 2.9)], [0.5, 0.5], marked(0, 0, -3.1, np.eye(3)), mapped())
    assert belief[0] > belief[1]


def test_a_pose_marked_in_the_robots_frame_is_turned_with_its_covariance() -> None:
    place = '{ from = "amcl", origin = { x = 1.0, y = 2.0, yaw_rad = 1.5707963267948966 } }'
    here = marked_belief(POSES, [1 / 3] * 3, marked(0.02, 0.01, 0.1, COVARIANCE), mapped(place))
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # from the world into the map
    moved = turn @ COVARIANCE @ turn.T
    x, y = turn[:2, :2] @ np.array([0.02 - 1.0, 0.01 - 2.0])
    there = marked(float(x), float(y), 0.1 - math.pi / 2, moved, frame="map")
    assert marked_belief(POSES, [1 / 3] * 3, there, mapped(place)) == pytest.approx(here, rel=1e-6)


def test_a_pose_that_the_prior_excludes_stays_excluded_and_far_poses_do_not_underflow() -> None:
    far = marked(1000.0, 0.0, 0.0, np.diag([1e-4, 1e-4, 1e-4]))
    belief = marked_belief(POSES, [0.0, 0.5, 0.5], far, mapped())
    assert belief[0] == 0.0
    assert sum(belief) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("pose", "said"),
    [
        (marked(0, 0, 0, COVARIANCE, frame="camera"), "frame_id: expected 'world', got 'camera'"),
        (marked(0, 0, 0, np.zeros((3, 3))), "covariance: expected variances"),
        (marked(0, 0, 0, np.full((3, 3), math.nan)), "covariance: expected variances"),
        (marked(0, 0, 0, np.array([[1.0, 2.0, 0], [2.0, 1.0, 0], [0, 0, 1.0]])), "positive definite"),
    ],
)
def test_a_marked_pose_that_cannot_be_used_is_refused(pose: PoseWithCovariance, said: str) -> None:
    with pytest.raises(UnusablePrior, match=said):
        marked_belief(POSES, [1 / 3] * 3, pose, mapped())


def test_poses_without_geometry_cannot_be_marked() -> None:
    with pytest.raises(UnusablePrior, match="poses with a position"):
        marked_belief([Pose(name="P1")], [1.0], marked(0, 0, 0, COVARIANCE), mapped())


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
@pytest.mark.parametrize(
    "rest",
    [(1.0, 0.0, 0.0, 0.0), (HALF, HALF, 0.0, 0.0), (HALF, 0.0, HALF, 0.0), (0.0, 1.0, 0.0, 0.0)],
    ids=["upright", "on its back", "on its nose", "upside down"],
)
def test_the_yaw_of_a_resting_object_turns_with_it(yaw: float, rest: tuple[float, float, float, float]) -> None:
    c, s = math.cos(yaw / 2), math.sin(yaw / 2)
    w, x, y, z = rest
    turned = Pose(
        name="P", position=[0, 0, 0], quaternion_wxyz=[c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
    )
    start = yaw_of(Pose(name="P", position=[0, 0, 0], quaternion_wxyz=list(rest)))
    assert math.remainder(yaw_of(turned) - start - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)
