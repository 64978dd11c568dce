"""Poses of scenarios as rigid motions, which every step of the set-up needs."""

from collections.abc import Sequence

import numpy as np

from voa_fleet.world.frames import Floats, matrix_of
from voa_msgs.scenarios import Pose


def matrix_of_pose(pose: Pose) -> Floats:
    """Return a pose as a rigid motion from the object's frame to the world's, (4, 4).

    Raises:
        ValueError: the pose has no position or no orientation.
    """
    if pose.position is None or pose.quaternion_wxyz is None:
        raise ValueError(f"expected position and quaternion_wxyz of pose {pose.name!r}")
    motion = np.eye(4)
    motion[:3, :3] = matrix_of(pose.quaternion_wxyz)
    motion[:3, 3] = pose.position
    return motion


def matrices_of_poses(poses: Sequence[Pose]) -> Floats:
    """Return poses as rigid motions from the object's frame to the world's, (n, 4, 4).

    Raises:
        ValueError: a pose has no position or no orientation.
    """
    return np.array([matrix_of_pose(pose) for pose in poses], dtype=np.float64).reshape(-1, 4, 4)
