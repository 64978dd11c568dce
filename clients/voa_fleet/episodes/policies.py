"""Policies: from where to look next, or whether to grasp.

| policy    | looks                                                                                     |
|-----------|-------------------------------------------------------------------------------------------|
| `voa`     | where the service says that it is worth most, until it says that grasping is better       |
| `random`  | anywhere, each place once, until the looks are used up                                    |
| `nearest` | from the place nearest to the robot, each place once, until the looks are used up         |
| `none`    | never                                                                                     |
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from voa_fleet.errors import UnknownName
from voa_msgs.geometry import SensorConfiguration, SensorPose
from voa_msgs.rankings import Look, Ranking

POLICIES = ("voa", "random", "nearest", "none")


@dataclass(frozen=True)
class Situation:
    """What a policy may know.

    Attributes:
        sensors: where the robot can stand.
        visited: names of those from which it has looked, in order.
        robot: where it believes to be.
        rank: asks the service.
    """

    sensors: tuple[SensorConfiguration, ...]
    visited: tuple[str, ...]
    robot: SensorPose
    rank: Callable[[], Ranking]

    @property
    def fresh(self) -> tuple[SensorConfiguration, ...]:
        """Places from which it has not looked."""
        return tuple(sensor for sensor in self.sensors if sensor.name not in self.visited)


@dataclass(frozen=True)
class Choice:
    """What a policy wants.

    Attributes:
        sensor: from where to look; None: grasp.
        ranking: what the service said, where it was asked.
    """

    sensor: str | None
    ranking: Ranking | None = None


class Policy(Protocol):
    """Chooses looks."""

    name: str

    def choose(self, now: Situation, /) -> Choice:
        """From where to look next, or to grasp."""


@dataclass
class ByVoa:
    """As the service recommends."""

    name: str = "voa"

    def choose(self, now: Situation) -> Choice:
        """The recommendation."""
        ranking = now.rank()
        advice = ranking.recommendation
        return Choice(advice.sensor if isinstance(advice, Look) else None, ranking)


@dataclass
class AtRandom:
    """Any place, by a generator of its own."""

    rng: np.random.Generator
    name: str = "random"

    def choose(self, now: Situation) -> Choice:
        """One of the places that are left."""
        fresh = now.fresh
        return Choice(fresh[int(self.rng.integers(len(fresh)))].name if fresh else None)


@dataclass
class Nearest:
    """The shortest drive."""

    name: str = "nearest"

    def choose(self, now: Situation) -> Choice:
        """The nearest of the places that are left; of two the first listed."""
        fresh = sorted(now.fresh, key=lambda sensor: math.hypot(sensor.x - now.robot.x, sensor.y - now.robot.y))
        return Choice(fresh[0].name if fresh else None)


@dataclass
class Never:
    """Grasps at once."""

    name: str = "none"

    def choose(self, _now: Situation) -> Choice:
        """To grasp."""
        return Choice(None)


def policy_named(name: str, seed: int | Sequence[int]) -> Policy:
    """A policy; the same seed makes the same choices.

    Raises:
        UnknownName: there is no such policy.
    """
    if name not in POLICIES:
        raise UnknownName("policy", name, list(POLICIES))
    made: dict[str, Callable[[], Policy]] = {
        "voa": ByVoa,
        "random": lambda: AtRandom(np.random.default_rng(seed)),
        "nearest": Nearest,
        "none": Never,
    }
    return made[name]()
