"""First scores of grasps from geometry alone: shares of displaced copies of the object that a hand grips."""

from collections.abc import Sequence

from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.scenarios import Pose
from voa_setup.grasps.hands import hands_of, heights
from voa_setup.grasps.shares import displacements, gripped_shares
from voa_setup.grasps.surface import sample_surface
from voa_setup.motions import matrices_of_poses

SAMPLES = 64
"""Displaced copies of the object per pose."""
FRICTION = 0.5
"""Coefficient of friction of rubber pads on most solids, on the safe side."""


def geometric_scores(
    mesh: Mesh,
    poses: Sequence[Pose],
    grasps: Sequence[GraspGeometry],
    gripper: GripperSetting,
    *,
    xy_m: float,
    yaw_rad: float,
    seed: int = 0,
    samples: int = SAMPLES,
    friction: float = FRICTION,
) -> list[list[float]]:
    """Score grasps by geometry: a first guess of their probabilities of success, (grasps, poses).

    A score is the share of displaced copies of the object that the hand reaches with open fingers without meeting
    the object, and then has between its fingers with antipodal contacts: the line between them lies in the friction
    cones of both. A hand that meets the table scores 0. Weight, slip and pushes are left to simulated attempts.

    Args:
        mesh: of the object.
        poses: with position and orientation.
        grasps: in the world frame.
        gripper: opening and sizes of the fingers.
        xy_m: standard deviation of the object's position about its pose, in x and in y.
        yaw_rad: standard deviation of its heading, about the pose's position.
        seed: of the points and the displacements; equal arguments give equal scores.
        samples: displaced copies per pose.
        friction: coefficient of both contacts.

    Raises:
        ValueError: a pose has no position or no orientation.
    """
    hands = hands_of(list(grasps))
    matrices = matrices_of_poses(poses)
    moves = displacements(samples, xy_m, yaw_rad, seed)
    shares = gripped_shares(sample_surface(mesh, seed), matrices, hands, gripper, moves, friction)
    shares[heights(hands, gripper) < 0.0] = 0.0
    return [[float(share) for share in row] for row in shares]
