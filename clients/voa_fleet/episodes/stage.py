"""The stage of a pair: a world, and in it the same seeded drops for every policy."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from voa_fleet.devices.clocks import Clock
from voa_fleet.devices.simulated import Scene, SimulatedArm, SimulatedSensorRobot, Watch, make_scene
from voa_fleet.errors import InvalidObject
from voa_fleet.world.imperfections import Clutter, Imperfections, wall
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty

CLUTTER: dict[str, Callable[[], tuple[Clutter, ...]]] = {
    "none": tuple,
    "wall": lambda: (wall("clutter wall", 0.0, -0.75, 2.0),),
    "box": lambda: (Clutter("clutter box", (0.16, 0.27), (0.10, 0.10, 0.25)),),
}
"""What may stand around beside the walls of the room: a wall behind the places to look from in the south, and a box
on the table's edge in front of the one in the north-north-east, which then sees little else."""


@dataclass(frozen=True, eq=False)
class Drop:
    """One object put down, and the devices around it.

    Attributes:
        index: of the drop.
        truth: the pose that it is in, which nobody on the stage knows.
    """

    index: int
    truth: str
    robot: SimulatedSensorRobot
    arm: SimulatedArm


@dataclass(frozen=True, eq=False)
class Stage:
    """A world for one pair. Its drops depend on (seed, index) alone, whatever was played before.

    Attributes:
        scene: the world as it stands.
        seed: of all drops.
        arm: whose plans are kept from drop to drop.
    """

    scene: Scene
    seed: int
    arm: SimulatedArm

    def drop(self, index: int) -> Drop:
        """Put the object down in a pose drawn from the scenario's prior, robot and arm back to where they wait.

        Raises:
            InvalidObject: the prior is not a list.
        """
        rng = np.random.default_rng([self.seed, index])
        thing = self.scene.world.object
        truth = thing.poses[int(rng.choice(len(thing.poses), p=shares(thing)))]
        scene = replace(self.scene, rng=rng)
        scene.put(truth)
        robot = SimulatedSensorRobot(scene, self.scene.world.robots[0], stated_by(scene.flaws))
        return Drop(index, truth, robot, replace(self.arm, scene=scene))

    def watched(self, watch: Watch) -> "Stage":
        """The same stage, with somebody who is told whenever something moves."""
        return replace(self, scene=replace(self.scene, watch=watch))


def make_stage(thing: FleetObject, flaws: Imperfections, seed: int, clock: Clock, robot: str) -> Stage:
    """A stage with the object, one sensor robot of that name, and an arm."""
    scene = make_scene(thing, clock, seed, flaws, robots=(robot,))
    return Stage(scene, seed, SimulatedArm(scene))


def shares(thing: FleetObject) -> list[float]:
    """Of the drops, per pose, (poses,): the scenario's prior.

    Raises:
        InvalidObject: the prior is not a list.
    """
    prior = thing.scenario.prior
    if prior is None:
        return [1.0 / len(thing.poses)] * len(thing.poses)
    if not isinstance(prior, list):
        raise InvalidObject(f"{thing.name}: expected a prior that lists a share per pose, got form {prior.form!r}")
    total = sum(prior)
    return [share / total for share in prior]


def stated_by(flaws: Imperfections) -> PoseUncertainty | None:
    """The standard deviations that an honest robot states; None where it has no error."""
    if flaws.robot_xy_m == 0.0 and flaws.robot_yaw_rad == 0.0:
        return None
    return PoseUncertainty(xy_m=flaws.robot_xy_m, yaw_rad=flaws.robot_yaw_rad)
