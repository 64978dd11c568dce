"""Reach of the fleet's arm: a cheap bound for many hands, and plans for those that are chosen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from voa_fleet.world.gripper import PALM_M
from voa_fleet.world.kinematics import APPROACH_M, is_reachable
from voa_fleet.world.objects import GripperSetting, named_object
from voa_fleet.world.scene import World, build_world
from voa_fleet.world.ur5e import BASE, LINKS
from voa_msgs.grasp_geometry import GraspGeometry
from voa_setup.grasps.hands import Hands


def within_bounds(hands: Hands, gripper: GripperSetting) -> NDArray[np.bool_]:
    """True for hands whose flange is near enough to the arm's shoulder, at both ends of the approach; (h,).

    The bound leaves out no hand that the arm can reach; some that it leaves in are out of reach.
    """
    shoulder = np.add(BASE, (0.0, 0.0, LINKS[0].d))
    longest = abs(LINKS[1].a) + abs(LINKS[2].a) + LINKS[3].d + LINKS[4].d
    wrist = PALM_M + gripper.finger_length_m + LINKS[5].d
    approach = hands.rotations[:, :, 2]
    reached = np.ones(len(hands), dtype=bool)
    for back in (wrist, wrist + APPROACH_M):
        reached &= np.linalg.norm(hands.tips - back * approach - shoulder, axis=1) <= longest
    return reached


@dataclass(frozen=True, eq=False)
class Reach:
    """Arm with a gripper.

    Attributes:
        world: in which the arm's motion is planned; the object in it does not matter.
    """

    world: World

    @classmethod
    def of(cls, gripper: GripperSetting) -> "Reach":
        """Mount a gripper on the arm."""
        target = named_object("block")
        return cls(build_world(replace(target, physics=target.physics.model_copy(update={"gripper": gripper}))))

    def includes(self, grasp: GraspGeometry) -> bool:
        """True if the arm has joint angles for the whole approach and the lift."""
        return is_reachable(self.world, grasp)
