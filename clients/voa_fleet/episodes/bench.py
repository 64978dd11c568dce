"""The bench of a pair: a table with one object, a sensor robot and an arm, on which drops are made."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from voa_fleet.devices.simulated import Scene, SimulatedArm, SimulatedSensorRobot, make_scene
from voa_fleet.episodes.priors import prior_of
from voa_fleet.world.attempts import Watch
from voa_fleet.world.clocks import Clock, VirtualClock
from voa_fleet.world.imperfections import Clutter, Imperfections, wall
from voa_fleet.world.object_poses import Drop, make_drop
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty, Spread

CLUTTER: dict[str, Callable[[], tuple[Clutter, ...]]] = {
    "none": tuple,
    "wall": lambda: (wall("clutter wall", 0.0, -0.75, 2.0),),
    "box": lambda: (Clutter("clutter box", (0.16, 0.27), (0.10, 0.10, 0.25)),),
}
"""Clutter beside the walls of the room, by name.

`wall` stands behind the sensor configurations in the south; `box` stands on the table's edge and hides most of the
object from the sensor configuration in the north-north-east."""


@dataclass(frozen=True, eq=False)
class PreparedDrop:
    """A drop on the bench, and the devices around it.

    Attributes:
        drop: the placement of the object.
        robot: the sensor robot, at the place where it waits.
        arm: the arm, at home.
    """

    drop: Drop
    robot: SimulatedSensorRobot
    arm: SimulatedArm


@dataclass(frozen=True, eq=False)
class Bench:
    """A table with one object, a sensor robot and an arm. Its drops depend on (seed, index) alone.

    Attributes:
        scene: the world and its state.
        seed: of all drops.
        arm: its plans are kept from drop to drop.
    """

    scene: Scene
    seed: int
    arm: SimulatedArm

    def prepare(self, index: int) -> PreparedDrop:
        """Make the drop with that index, in a pose drawn from the scenario's prior; robot and arm go back to wait.

        Raises:
            InvalidObject: the scenario's prior does not fit its poses.
        """
        rng = np.random.default_rng([self.seed, index])
        target = self.scene.world.object
        return self.place(make_drop(target, index, prior_of(target), self.scene.imperfections, rng), rng)

    def place(self, drop: Drop, rng: np.random.Generator, imperfections: Imperfections | None = None) -> PreparedDrop:
        """Place the object as a given drop says; robot and arm go back to where they wait.

        Args:
            drop: the placement.
            rng: of the errors of robot and lidar from now on.
            imperfections: sizes of these errors; None: those of the scene. Clutter is part of the world and stays.
        """
        scene = replace(self.scene, rng=rng, imperfections=imperfections or self.scene.imperfections)
        scene.put(drop.place)
        robot = SimulatedSensorRobot(scene, self.scene.world.robots[0], stated_by(scene.imperfections))
        return PreparedDrop(drop, robot, replace(self.arm, scene=scene))

    def watched(self, watch: Watch) -> "Bench":
        """Return this bench with a function that is called with the state whenever something has moved."""
        return replace(self, scene=replace(self.scene, watch=watch))


def make_bench(
    target: FleetObject, imperfections: Imperfections, seed: int, clock: Clock | None = None, robot: str = "robot"
) -> Bench:
    """Build a bench.

    Args:
        target: the object.
        imperfections: sizes of all errors, and the clutter.
        seed: of all drops.
        clock: by which time passes; None: a virtual one.
        robot: name of the sensor robot.
    """
    scene = make_scene(target, clock or VirtualClock(), seed, imperfections, robots=(robot,))
    return Bench(scene, seed, SimulatedArm(scene))


def stated_by(imperfections: Imperfections) -> PoseUncertainty | None:
    """Return the standard deviations that a robot states which knows its errors; None where it has no error."""
    if imperfections.robot_xy_m == 0.0 and imperfections.robot_yaw_rad == 0.0:
        return None
    return PoseUncertainty(xy_m=imperfections.robot_xy_m, yaw_rad=imperfections.robot_yaw_rad)


def spread_of(imperfections: Imperfections) -> Spread | None:
    """Return the standard deviations by which the object lies off its pose; None where it lies at it exactly."""
    if imperfections.object_xy_m == 0.0 and imperfections.object_yaw_rad == 0.0:
        return None
    return Spread(xy_m=imperfections.object_xy_m, yaw_rad=imperfections.object_yaw_rad)
