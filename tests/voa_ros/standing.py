"""Simulated robot that sends revolutions to a look taker, in a room or with a measured pose."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import count
from random import Random

from tests.voa_ros.ros_messages import scan
from voa_msgs.geometry import UncertainSensorPose
from voa_ros.grids import BeamGrid
from voa_ros.look_taker import LookTaker
from voa_ros.looks import GatheredLook, Waiting, Where
from voa_ros.messages import LaserScan
from voa_ros.robots import LookRule
from voa_ros.tracks import NoPose

INF, NAN = math.inf, math.nan
BEAMS = 90
SCANS = 5
GRID = BeamGrid(BEAMS, 0.0, math.tau / BEAMS)


def at(x: float = 0.0, y: float = 0.0, yaw_rad: float = 0.0) -> UncertainSensorPose:
    """Pose of the lidar, metres and radians."""
    return UncertainSensorPose(x=x, y=y, yaw_rad=yaw_rad)


def room(x: float = 0.0, y: float = 0.0, turned: int = 0) -> list[float]:
    """Ranges of a lidar at a place in a room of 3 m by 2 m with a box."""
    ranges = []
    for beam in range(BEAMS):
        angle = math.tau * (beam + turned) / BEAMS
        cos, sin = math.cos(angle), math.sin(angle)
        walls = [
            ((1.5 if cos > 0 else -1.5) - x) / cos if cos else INF,
            ((1.0 if sin > 0 else -1.0) - y) / sin if sin else INF,
        ]
        box = 0.4 - x if abs(math.remainder(angle, math.tau)) < 0.2 else INF
        ranges.append(min(*walls, box))
    return ranges


@dataclass
class Robot:
    """Robot that sends the revolutions of an LDS-01 to a look taker, and keeps its looks and reasons."""

    taker: LookTaker
    noise: float = 0.035
    lost: float = 0.05
    chance: Random = field(default_factory=lambda: Random(7))  # noqa: S311  # noise, not a secret
    turns: Iterator[int] = field(default_factory=lambda: count(1))
    looks: list[GatheredLook] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)

    def measured(self, ranges: Iterable[float]) -> tuple[float, ...]:
        noisy = [value * (1.0 + self.chance.gauss(0.0, self.noise)) for value in ranges]
        if len(noisy) >= 6 and self.chance.random() < self.lost:
            start = self.chance.randrange(len(noisy) // 6) * 6
            noisy[start : start + 6] = [0.0] * 6
        return tuple(noisy)

    def scan(self, ranges: Iterable[float]) -> LaserScan:
        return scan(*self.measured(ranges), at=0.2 * next(self.turns), increment=math.tau / BEAMS)

    def turn(self, where: Where | NoPose, ranges: Iterable[float] | None = None) -> GatheredLook | Waiting:
        return self.send(self.scan(room() if ranges is None else ranges), where)

    def send(self, measured: LaserScan, where: Where | NoPose) -> GatheredLook | Waiting:
        answer = self.taker.receive(measured, where)
        if isinstance(answer, GatheredLook):
            self.looks.append(answer)
        else:
            self.reasons.append(answer.reason)
        return answer


def robot(mode: str = "stationary", **more: object) -> Robot:
    return Robot(LookTaker("tb3_1", LookRule.model_validate({"mode": mode, "scans": SCANS, **more}), GRID))


def last_reason(own: Robot) -> str:
    assert own.reasons[-1] == own.taker.waiting_for
    return own.reasons[-1]
