"""Rotations, and the tool's frame for a direction of approach."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def matrix_of(quaternion_wxyz: ArrayLike) -> Floats:
    """Return the rotation matrix (3, 3) of a quaternion (w, x, y, z) of any length but 0."""
    q = np.asarray(quaternion_wxyz, dtype=np.float64)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def product(first: ArrayLike, second: ArrayLike) -> Floats:
    """Multiply two quaternions (w, x, y, z): the result turns by `second`, then by `first`."""
    w, x, y, z = np.asarray(first, dtype=np.float64)
    a, b, c, d = np.asarray(second, dtype=np.float64)
    return np.array(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def yaw_quaternion(yaw_rad: float) -> Floats:
    """Return the quaternion (w, x, y, z) of a turn by `yaw_rad` about the vertical, counter-clockwise."""
    return np.array([math.cos(yaw_rad / 2.0), 0.0, 0.0, math.sin(yaw_rad / 2.0)])


def along(axis: ArrayLike) -> Floats:
    """Return a quaternion (w, x, y, z) that turns the z axis to `axis` (3,), a vector of any length but 0."""
    unit = np.asarray(axis, dtype=np.float64)
    unit = unit / np.linalg.norm(unit)
    if unit[2] < -1.0 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    quaternion = np.array([1.0 + unit[2], -unit[1], unit[0], 0.0])
    turned: Floats = quaternion / np.linalg.norm(quaternion)
    return turned


def tool_rotation(approach: ArrayLike, closing: ArrayLike) -> Floats:
    """Return the tool's rotation (3, 3): z along `approach`, x along the part of `closing` perpendicular to it."""
    z = np.asarray(approach, dtype=np.float64)
    z = z / np.linalg.norm(z)
    x = np.asarray(closing, dtype=np.float64)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def angle_between(first: Floats, second: Floats) -> float:
    """Return the angle between two unit vectors (3,), radians, from 0 to pi."""
    return math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
