"""Rest of a dropped object: stability of the scenario's poses, and a prior from counts of drops."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from math import radians

import mujoco
import numpy as np

from voa_fleet.world.frames import Floats, angle_between, matrix_of
from voa_fleet.world.object_poses import ObjectPose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import STEP_S, World, build_world

STABLE_RAD = radians(5.0)
"""Tilt from which a pose is not stable when the object is released."""
SAME_RAD = radians(10.0)
"""Angle between upward directions of the object below which two ways to rest are equal."""
OTHER, MOVING = "other", "still moving"

_SETTLE_S, _DROP_S = 1.0, 3.0
_CLEARANCE_M = 0.02
_STILL = 0.01
"""Speed below which the object is at rest, metres and radians per second."""


@dataclass(frozen=True)
class RestCounts:
    """Counts of the ways in which a dropped object came to rest.

    Attributes:
        object: name of the object.
        counts: by the way to rest; `other` for one that the object's physics do not name, `still moving` for none.
        seed: of the orientations.
    """

    object: str
    counts: dict[str, int]
    seed: int

    @property
    def total(self) -> int:
        """Number of all drops."""
        return sum(self.counts.values())


def tilt_when_let_go(target: FleetObject, pose: str) -> float:
    """Measure the tilt within a second after release at a pose, radians; stable poses stay below 5 degrees.

    Raises:
        UnknownName: there is no such pose.
        UnstableSimulation: the simulation became unstable.
    """
    world = _bare_table(target)
    data = mujoco.MjData(world.model)
    world.put_object(data, scenario_pose(target, pose))
    before = world.up(data)
    world.step(data, round(_SETTLE_S / STEP_S))
    return angle_between(before, world.up(data))


def drop_repeatedly(
    target: FleetObject, count: int, seed: int, progress: Callable[[int], None] | None = None
) -> RestCounts:
    """Drop the object `count` times, turned at random, from 2 cm over the table, and count how it comes to rest.

    Raises:
        UnstableSimulation: the simulation became unstable.
    """
    world = _bare_table(target)
    counts: Counter[str] = Counter()
    for index in range(count):
        counts[_drop_once(world, np.random.default_rng([seed, index]))] += 1
        if progress is not None:
            progress(1)
    names = [*target.physics.rests, OTHER, MOVING]
    return RestCounts(target.name, {name: counts[name] for name in names}, seed)


def prior_from(target: FleetObject, rests: RestCounts) -> list[float]:
    """Derive a prior, (poses,), from counts: the share of each way to rest, divided equally among its poses.

    Ways to rest without a pose in the scenario are left out: the prior is conditional on the object being in one of
    the scenario's poses.

    Raises:
        ValueError: the object never came to rest in any of them.
    """
    seen = {name: rests.counts[name] for name, rest in target.physics.rests.items() if rest.poses}
    total = sum(seen.values())
    if total == 0:
        raise ValueError(f"in {rests.total} drops the {target.name} never came to rest in a pose of its scenario")
    share = {
        pose: seen[name] / total / len(rest.poses) for name, rest in target.physics.rests.items() for pose in rest.poses
    }
    return [share[pose] for pose in target.poses]


def rest_of(target: FleetObject, up: Floats) -> str:
    """Name the way to rest with the world's z axis at `up` (3,) in the object's frame; `other` if it has no name."""
    for name, rest in target.physics.rests.items():
        for own in rest.ups:
            direction = np.array(own)
            if angle_between(up, direction / np.linalg.norm(direction)) < SAME_RAD:
                return name
    return OTHER


def _bare_table(target: FleetObject) -> World:
    """Build a world with the object alone on a wide table.

    A bench would change the counts: a dropped object hits its arm, or rolls off its smaller table.
    """
    return build_world(target, arm=False)


def _drop_once(world: World, rng: np.random.Generator) -> str:
    quaternion = rng.standard_normal(4)
    quaternion /= np.linalg.norm(quaternion)
    lowest = float((world.object.mesh.vertices @ matrix_of(quaternion)[2]).min())
    w, i, j, k = (float(part) for part in quaternion)
    data = mujoco.MjData(world.model)
    world.put_object(data, ObjectPose((0.0, 0.0, _CLEARANCE_M - lowest), (w, i, j, k)))
    world.step(data, round(_DROP_S / STEP_S))
    if np.abs(data.qvel).max() > _STILL:
        return MOVING
    return rest_of(world.object, world.up(data))
