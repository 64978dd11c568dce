"""Rotations: quaternions (w, x, y, z), matrices, and the turn about the vertical."""

import numpy as np

from voa_core.checks import Floats
from voa_core.errors import InvalidInput

_UNIT_TOLERANCE = 0.05  # quaternions are often written with two digits


def matrices_of_quaternions(quaternions_wxyz: Floats) -> Floats:
    """Rotation matrices of quaternions.

    Args:
        quaternions_wxyz: shape (n, 4), w first; normalised here.

    Returns:
        Shape (n, 3, 3): columns are the body's axes in the world frame.

    Raises:
        InvalidInput: a quaternion's norm is off 1 by more than 0.05.
    """
    norms = np.linalg.norm(quaternions_wxyz, axis=1)
    wrong = np.flatnonzero(np.abs(norms - 1.0) > _UNIT_TOLERANCE)
    if wrong.size:
        raise InvalidInput("quaternion_wxyz", "a unit quaternion", f"norm {norms[wrong[0]]:.6g} at {wrong[0]}")
    w, x, y, z = (quaternions_wxyz / norms[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def quaternion_of_matrix(matrix: Floats) -> Floats:
    """Quaternion (w, x, y, z), w >= 0, of one rotation matrix of shape (3, 3).

    It is the largest eigenvector of Bar-Itzhack's symmetric matrix (J. Guidance 23(6), 2000), which needs no
    case distinction.
    """
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    vector = np.linalg.eigh(k)[1][:, -1]  # eigh reads the lower triangle
    wxyz: Floats = vector[[3, 0, 1, 2]]
    return -wxyz if wxyz[0] < 0 else wxyz


def turn(yaw_rad: float) -> Floats:
    """Rotation matrix (3, 3) of a turn by `yaw_rad` about the vertical."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def upright_rotation(up: Floats) -> Floats:
    """Rotations whose last row is the unit vector `up`: each turns `up` (body frame) to the z axis.

    The result depends on `up` alone: bodies that differ by a turn about the vertical share it.

    Args:
        up: (..., 3).

    Returns:
        Shape (..., 3, 3).
    """
    helper = np.eye(3)[np.argmin(np.abs(up), axis=-1)]
    first = np.cross(helper, up)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(up, first), up], axis=-2)
