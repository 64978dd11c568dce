"""Drops of one object: where it lies, the scans that are really taken of it, the grasps that are really attempted.

A drop, its scans and its attempts depend on the seed and on names alone. So every policy, rule and level of a
disturbance meets the same drop, and what they share cancels in a difference.
"""

import math
import zlib
from dataclasses import dataclass, field

import mujoco
import numpy as np

from voa_evaluation.looks.setting import Belief
from voa_fleet.world.attempts import Result, attempt_grasp, noisy_pose, object_pose, open_fingers
from voa_fleet.world.imperfections import Clutter, Imperfections
from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.lidar import LidarGeometry, lidar_geometry, scan_message, true_ranges, with_faults
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import ObjectPose, World, build_world
from voa_fleet.world.ur5e import HOME
from voa_msgs.geometry import SensorConfiguration, SensorPose
from voa_msgs.sessions import Scan

HINT = 0.5
"""Concentration of the Dirichlet distribution of hinted beliefs: below 1, so that a few poses have most of it."""
_BOX_M = 0.04
_NEAR_M, _FAR_M = 0.13, 0.25


@dataclass(frozen=True)
class Drop:
    """The object put down once.

    Attributes:
        kind: of belief.
        index: from 0, within object and kind.
        belief: before any look, over the scenario's poses; the pose is drawn from it.
        pose: name of the true pose.
        place: where the object lies, its noise included.
        bearing_rad: from where the sensor robot comes.
        random_look: an index drawn evenly from the sensor configurations.
    """

    object: str
    kind: Belief
    index: int
    belief: tuple[float, ...]
    pose: str
    place: ObjectPose
    bearing_rad: float
    random_look: int


def source(seed: int, *what: str | int) -> np.random.Generator:
    """The source of chance for a target that is named."""
    return np.random.default_rng(
        [seed, *(part if isinstance(part, int) else zlib.crc32(part.encode()) for part in what)]
    )


def make_drop(target: FleetObject, kind: Belief, index: int, imperfections: Imperfections, seed: int) -> Drop:
    """Draw a drop."""
    rng = source(seed, "drop", target.name, kind, index)
    count = len(target.poses)
    belief = np.full(count, 1.0 / count) if kind == "uniform" else rng.dirichlet(np.full(count, HINT))
    pose = target.poses[int(rng.choice(count, p=belief))]
    return Drop(
        object=target.name,
        kind=kind,
        index=index,
        belief=tuple(float(share) for share in belief),
        pose=pose,
        place=noisy_pose(object_pose(target, pose), imperfections, rng),
        bearing_rad=float(rng.uniform(0.0, 2.0 * math.pi)),
        random_look=int(rng.integers(len(target.scenario.sensors))),
    )


def boxes(drop: Drop, count: int, seed: int) -> tuple[Clutter, ...]:
    """Boxes of 4 x 4 cm that stand 13 to 25 cm from the middle of the table; the first of more are those of fewer."""
    rng = source(seed, "clutter", drop.object, drop.kind, drop.index)
    found = []
    for index in range(count):
        distance, bearing, yaw = rng.uniform([_NEAR_M, 0.0, 0.0], [_FAR_M, 2.0 * math.pi, math.pi])
        centre = distance * math.cos(bearing), distance * math.sin(bearing)
        found.append(Clutter(f"box{index}", centre, (_BOX_M, _BOX_M, 0.2), yaw))
    return tuple(found)


@dataclass(eq=False)
class Table:
    """The table with one object, the arm at home: takes scans, attempts grasps and remembers what came of them.

    Attributes:
        target: the object.
        seed: of the scans' faults.
    """

    target: FleetObject
    seed: int
    _lidar: LidarGeometry = field(init=False)
    _worlds: dict[tuple[Clutter, ...], World] = field(default_factory=dict)
    _plans: dict[str, GraspPlan | None] = field(default_factory=dict)
    _results: dict[tuple[str, int, str], Result] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._lidar = lidar_geometry(self.target.scenario.lidar)

    def scan(self, drop: Drop, sensor: SensorConfiguration, imperfections: Imperfections) -> Scan:
        """One revolution from where the robot really stands when it believes to stand at `sensor`.

        The same random numbers whatever the imperfections are: two levels of a disturbance differ in it alone.
        """
        world = self._world(imperfections.clutter)
        data = mujoco.MjData(world.model)
        data.qpos[world.joints] = HOME
        open_fingers(world, data)
        world.put_object(data, drop.place)
        mujoco.mj_kinematics(world.model, data)
        rng = source(self.seed, "scan", drop.object, drop.kind, drop.index, sensor.name)
        dx, dy, turn = (float(number) for number in rng.standard_normal(3))
        stand = SensorPose(
            x=sensor.x + dx * imperfections.robot_xy_m,
            y=sensor.y + dy * imperfections.robot_xy_m,
            yaw_rad=sensor.yaw_rad + turn * imperfections.robot_yaw_rad,
            height_m=sensor.height_m,
        )
        return scan_message(with_faults(true_ranges(world, data, self._lidar, stand), self._lidar, imperfections, rng))

    def attempt(self, drop: Drop, grasp: str) -> Result:
        """What comes of a grasp where the object lies; every pair of drop and grasp is simulated once."""
        key = drop.kind, drop.index, grasp
        if key not in self._results:
            world = self._world(())
            if grasp not in self._plans:
                self._plans[grasp] = plan_grasp(world, self.target.grasp(grasp))
            self._results[key] = attempt_grasp(world, self._plans[grasp], drop.place).result
        return self._results[key]

    @property
    def attempts(self) -> int:
        """How many have been made."""
        return len(self._results)

    def _world(self, clutter: tuple[Clutter, ...]) -> World:
        if any(box.name.startswith("box") for box in clutter):
            return build_world(self.target, clutter=clutter)  # of one drop: not worth keeping
        if clutter not in self._worlds:
            self._worlds[clutter] = build_world(self.target, clutter=clutter)
        return self._worlds[clutter]
