"""Setting of an evaluation of values: objects' errors, numbers of scans, beliefs and sessions. Fixed before the run."""

import math
from dataclasses import dataclass

from voa_core.rules.registry import RULES

SPREAD_XY_M, SPREAD_YAW_RAD = 0.005, math.radians(3.0)
"""Standard deviations by which every object lies off its listed pose; every scenario states them as its spread."""


@dataclass(frozen=True)
class RobotError:
    """Error of the sensor robot's pose, which the robot states correctly.

    Attributes:
        xy_m: standard deviation in each of x and y, metres.
        yaw_rad: standard deviation of the heading, radians.
    """

    xy_m: float
    yaw_rad: float

    @property
    def name(self) -> str:
        """Text of tables, such as "1 cm, 1 deg"."""
        if self.xy_m == self.yaw_rad == 0.0:
            return "0"
        return f"{100.0 * self.xy_m:g} cm, {math.degrees(self.yaw_rad):g} deg"


ROBOT_ERRORS = (RobotError(0.0, 0.0), RobotError(0.01, math.radians(1.0)), RobotError(0.03, math.radians(2.0)))
SESSION_RULES = ("beam", "inverse_rmsd")
"""Update rules of the sessions of several looks."""
PLANNED_RULE = "beam"
"""Update rule of pairs, of driving and of two robots."""
DRIVING_COSTS = (0.0, 0.05, 0.1, 0.2)
"""Success probability that a metre of driving costs, in the evaluation of driving."""


@dataclass(frozen=True)
class Setting:
    """Extent of an evaluation of values.

    Attributes:
        scans: number of fresh noisy scans of each pose from each place, an even number of at least 4.
        beliefs: number of hinted beliefs of each object, beside the uniform one.
        sessions: number of sessions of three looks, for each object, robot error and way of choosing; 0: none.
        drops: number of end-to-end drops in MuJoCo for each object; 0: none.
        seed: of all random numbers.
        rules: names of the update rules.
        robot_errors: errors of the sensor robot.
    """

    scans: int = 400
    beliefs: int = 50
    sessions: int = 100
    drops: int = 100
    seed: int = 0
    rules: tuple[str, ...] = tuple(RULES)
    robot_errors: tuple[RobotError, ...] = ROBOT_ERRORS


QUICK = Setting(scans=60, beliefs=6, sessions=12, drops=8, robot_errors=ROBOT_ERRORS[:2])
"""Setting of a trial run, within 90 seconds: its intervals are wide, and the largest robot error is left out."""
