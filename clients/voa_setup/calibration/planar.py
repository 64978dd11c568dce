"""Planar poses (k, 3), x and y in metres and yaw in radians, composed and inverted all at once."""

import numpy as np
from numpy.typing import NDArray

from voa_ros.motions import Planar

Floats = NDArray[np.float64]


def planar(pose: Planar) -> Floats:
    """Return a pose as an array (3,)."""
    return np.array([pose.x, pose.y, pose.yaw_rad], dtype=np.float64)


def wrapped(angles: Floats) -> Floats:
    """Wrap angles to [-pi, pi) radians."""
    return np.asarray(np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi, dtype=np.float64)


def composed(frames: Floats, inside: Floats) -> Floats:
    """Compose poses of frames with poses inside them; either (3,) or (k, 3)."""
    cos, sin = np.cos(frames[..., 2]), np.sin(frames[..., 2])
    return np.stack(
        [
            frames[..., 0] + cos * inside[..., 0] - sin * inside[..., 1],
            frames[..., 1] + sin * inside[..., 0] + cos * inside[..., 1],
            wrapped(frames[..., 2] + inside[..., 2]),
        ],
        axis=-1,
    )


def inverse(poses: Floats) -> Floats:
    """Invert poses, (3,) or (k, 3)."""
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = poses[..., 0], poses[..., 1]
    return np.stack([-cos * x - sin * y, sin * x - cos * y, wrapped(-poses[..., 2])], axis=-1)
