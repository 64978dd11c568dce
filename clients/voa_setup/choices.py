"""Choices of a person about a new scenario, with their defaults."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from voa_fleet.world.objects import GripperSetting
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.objects import UpAxis
from voa_setup.grippers import gripper_named
from voa_setup.poses import LEAST_PROBABILITY, even_yaws

SIMULATED, GEOMETRIC = "simulated", "geometric"
"""Sources of grasp scores: attempts in the physics simulation, or a first guess from the shapes alone."""
XY_M, YAW_DEG = 0.005, 3.0
"""Spread where none is stated: standard deviations of the object about a pose, metres and degrees."""
ATTEMPTS = 15
"""Simulated attempts of each grasp at each pose."""
GRIPPER = "2f-85"
"""Name of the gripper where none is stated."""


@dataclass(frozen=True)
class Choices:
    """Choices of a person about a new scenario; each has a default but the mesh.

    Attributes:
        mesh: file to read.
        scale: metres per unit of the file; None: 1, if the size is likely.
        up: axis of the file that points up; None: +Y for GLB, else +Z.
        yaws_deg: turns of every rest about the vertical, degrees.
        positions: x, y on the table over which the centre of mass lies, metres.
        least_probability: rests less probable than this are left out.
        rests: names of the rests to keep, however probable; None: all that are probable enough.
        xy_m, yaw_deg: spread of the object about a pose: standard deviations in metres and degrees.
        gripper: opening, force and finger size.
        grasps: most grasps to propose.
        density_kg_m3, friction: of the object, for grasps and simulated attempts.
        places: a number of places on a ring, or the places themselves.
        radius_m: of the ring; None: 0.45, or more for a large object.
        lidar: name of a preset.
        height_m: of the scan plane; None: the suggestion.
        scores: `simulated`, `geometric`, or a file with a table of successes and attempts.
        attempts: simulated attempts of each grasp at each pose.
        processes: number of processes that simulate at the same time.
        seed: of everything that is drawn at random: equal choices give equal files.
        force: True to write over a scenario in the folder.
    """

    mesh: Path
    scale: float | None = None
    up: UpAxis | None = None
    yaws_deg: Sequence[float] = field(default_factory=lambda: even_yaws(8))
    positions: Sequence[tuple[float, float]] = ((0.0, 0.0),)
    least_probability: float = LEAST_PROBABILITY
    rests: Sequence[str] | None = None
    xy_m: float = XY_M
    yaw_deg: float = YAW_DEG
    gripper: GripperSetting = field(default_factory=lambda: gripper_named(GRIPPER))
    grasps: int = 12
    density_kg_m3: float = 500.0
    friction: float = 0.5
    places: int | Sequence[SensorConfiguration] = 8
    radius_m: float | None = None
    lidar: str = "lds-02"
    height_m: float | None = None
    scores: str | Path = SIMULATED
    attempts: int = ATTEMPTS
    processes: int = 2
    seed: int = 0
    force: bool = False

    @property
    def yaw_rad(self) -> float:
        """Standard deviation of the object's yaw about a pose, radians."""
        return round(math.radians(self.yaw_deg), 6)
