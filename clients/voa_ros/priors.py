"""Beliefs from the pose of the object that a person marks, for example with "2D Pose Estimate" of RViz.

A marked pose has a covariance. The weight of a listed pose is the density of that normal distribution, in x, y and yaw,
at the pose, times the session's prior, so that rests of the object keep their own probabilities: where all poses share
a position, the yaw decides.
"""

import math
from collections.abc import Sequence

from voa_msgs.scenarios import Pose as ListedPose
from voa_ros.messages import PoseWithCovariance
from voa_ros.motions import Motion, composed, wrapped
from voa_ros.outputs.places import localisation_frame, localisation_origin
from voa_ros.robots import RobotMapping

_X, _Y, _YAW = 0, 1, 5
"""Indices of x, y and yaw in a covariance of six coordinates."""
_LEAST_VARIANCES = (1e-6, 1e-6, 1e-5)
"""Added to the variances of x, y (m^2) and yaw (rad^2): a person does not mark more exactly."""
_LEVEL = 0.5
"""Share of a horizontal axis of the object above which that axis states the yaw."""

Matrix = list[list[float]]


class UnusablePrior(ValueError):
    """Error for a marked pose from which no belief follows; its text says what was expected."""


def marked_belief(
    poses: Sequence[ListedPose], prior: Sequence[float], marked: PoseWithCovariance, mapping: RobotMapping
) -> list[float]:
    """Compute the belief over poses after a person has marked where the object lies.

    Args:
        poses: of the scenario.
        prior: probability of each pose before.
        marked: in the world's frame, or in the frame in which the robot knows its own pose.
        mapping: names these frames.

    Returns:
        A probability for each pose; they sum to 1.

    Raises:
        UnusablePrior: the frame is another one, the covariance is not one, or no pose is near.
    """
    middle, covariance = _in_world(marked, mapping)
    factor = _root(covariance)
    logs = [
        math.log(share) - _distance(factor, _difference(pose, middle)) / 2.0
        if share > 0.0 and pose.position is not None and pose.quaternion_wxyz is not None
        else -math.inf
        for pose, share in zip(poses, prior, strict=True)
    ]
    largest = max(logs)
    if largest == -math.inf:
        raise UnusablePrior("expected poses with a position in the scenario, of a probability above 0 in its prior")
    weights = [math.exp(each - largest) for each in logs]
    total = math.fsum(weights)
    return [weight / total for weight in weights]


def yaw_of(pose: ListedPose) -> float:
    """Yaw of an object at a pose, radians: direction of its x axis seen from above, or of its y axis less 90 degrees.

    The y axis states it where the x axis is steep, as after a rotation of 90 degrees about y.
    """
    w, x, y, z = pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0)
    along_x = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z))
    if math.hypot(*along_x) >= _LEVEL:
        return math.atan2(along_x[1], along_x[0])
    along_y = (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z))
    return wrapped(math.atan2(along_y[1], along_y[0]) - math.pi / 2.0)


def _in_world(marked: PoseWithCovariance, mapping: RobotMapping) -> tuple[Motion, Matrix]:
    """Return the marked pose, and the covariance of its x, y and yaw, in the world's frame."""
    x, y, _ = marked.pose.position
    own = Motion(x, y, marked.pose.yaw_rad)
    indices = (_X, _Y, _YAW)
    covariance = [[marked.covariance[6 * row + column] for column in indices] for row in indices]
    if not all(math.isfinite(value) for row in covariance for value in row) or covariance == [[0.0] * 3] * 3:
        raise UnusablePrior("covariance: expected variances of x, y and yaw, in m^2 and rad^2, above 0")
    for index, least in enumerate(_LEAST_VARIANCES):
        covariance[index][index] += least
    if marked.frame_id == mapping.outputs.frame_id:
        return own, covariance
    origin = localisation_origin(mapping)
    if origin is not None and marked.frame_id == localisation_frame(mapping):
        return composed(origin, own), _rotated(covariance, origin.yaw_rad)
    frames = sorted({mapping.outputs.frame_id, localisation_frame(mapping)})
    raise UnusablePrior(f"frame_id: expected {' or '.join(map(repr, frames))}, got {marked.frame_id!r}")


def _rotated(covariance: Matrix, yaw_rad: float) -> Matrix:
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
    half = [[sum(turn[i][k] * covariance[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[sum(half[i][k] * turn[j][k] for k in range(3)) for j in range(3)] for i in range(3)]


def _root(covariance: Matrix) -> Matrix:
    """Return the lower triangular L with L L^T equal to a covariance (Cholesky)."""
    root = [[0.0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(i + 1):
            rest = covariance[i][j] - sum(root[i][k] * root[j][k] for k in range(j))
            if i == j and not rest > 0.0:
                raise UnusablePrior("covariance: expected a positive definite matrix in x, y and yaw")
            root[i][j] = math.sqrt(rest) if i == j else rest / root[j][j]
    return root


def _difference(pose: ListedPose, middle: Motion) -> tuple[float, float, float]:
    x, y, _ = pose.position or (0.0, 0.0, 0.0)
    return (x - middle.x, y - middle.y, wrapped(yaw_of(pose) - middle.yaw_rad))


def _distance(root: Matrix, difference: Sequence[float]) -> float:
    """Return the squared Mahalanobis distance, by forward substitution."""
    solved: list[float] = []
    for i in range(3):
        solved.append((difference[i] - sum(root[i][k] * solved[k] for k in range(i))) / root[i][i])
    return sum(value * value for value in solved)
