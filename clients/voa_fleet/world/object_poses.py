"""Poses of the object on the table: those of the scenario, and noise about them."""

from dataclasses import dataclass

import numpy as np

from voa_fleet.world.frames import product, yaw_quaternion
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject


@dataclass(frozen=True)
class ObjectPose:
    """Position and orientation of the object's frame in the world frame.

    Attributes:
        position: x, y, z, metres.
        quaternion_wxyz: a unit quaternion.
    """

    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, float, float, float]


@dataclass(frozen=True)
class Drop:
    """A placement of the object on the table.

    Attributes:
        index: number of the drop in its series, from 0.
        pose: name of the scenario's pose in which the object lies; the robots do not know it.
        place: true position and orientation of the object: the pose and its noise.
    """

    index: int
    pose: str
    place: ObjectPose


def scenario_pose(target: FleetObject, name: str) -> ObjectPose:
    """Return the exact pose of that name from the object's scenario; raises UnknownName."""
    pose = target.pose(name)
    x, y, z = pose.position or (0.0, 0.0, 0.0)
    w, i, j, k = pose.quaternion_wxyz or (1.0, 0.0, 0.0, 0.0)
    return ObjectPose((x, y, z), (w, i, j, k))


def noisy_pose(pose: ObjectPose, imperfections: Imperfections, rng: np.random.Generator) -> ObjectPose:
    """Move a pose at random in the plane, and turn it about the vertical through the object frame's origin."""
    deviations = [imperfections.object_xy_m, imperfections.object_xy_m, imperfections.object_yaw_rad]
    dx, dy, turn = rng.standard_normal(3) * deviations
    x, y, z = pose.position
    w, i, j, k = (float(part) for part in product(yaw_quaternion(float(turn)), pose.quaternion_wxyz))
    return ObjectPose((x + float(dx), y + float(dy), z), (w, i, j, k))


def make_drop(
    target: FleetObject, index: int, belief: list[float], imperfections: Imperfections, rng: np.random.Generator
) -> Drop:
    """Draw a drop: a pose from the belief, and the noise of its place.

    Args:
        target: the object.
        index: number of the drop.
        belief: probability of each of the scenario's poses, (poses,).
        imperfections: the noise of the place.
        rng: decides both.
    """
    pose = target.poses[int(rng.choice(len(target.poses), p=belief))]
    return Drop(index, pose, noisy_pose(scenario_pose(target, pose), imperfections, rng))
