"""Policies: they choose from where to look next, or to grasp. This is the only registry of policies.

The names and descriptions of the built-in ones are in `POLICIES`. An installed package adds its own by an entry point
of the group `voa.policies`: the entry point's name is the policy's, its value a class or function without arguments
that makes a `Policy`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Protocol, runtime_checkable

import numpy as np

from voa_client import next_look
from voa_fleet.episodes.forecasts import Forecast
from voa_fleet.errors import InvalidPolicy, UnknownName
from voa_msgs.geometry import SensorConfiguration, SensorPose
from voa_msgs.rankings import Ranking

GROUP = "voa.policies"
"""Group of the entry points by which installed packages add policies."""


@dataclass(frozen=True)
class Situation:
    """State of an episode in which a policy chooses.

    Attributes:
        sensors: all sensor configurations of the scenario, in order.
        visited: names of those from which the robot has looked, in order.
        robot: pose of the lidar as the robot estimates it.
        belief: probability of each pose, (poses,).
        rank: requests the service's ranking of the looks.
        forecast: requests the predicted scans and the updates by them; many requests, so keep the result.
        draw: draws a whole number from 0 to below its argument, each as likely; an episode's seed decides them.
        looks_left: largest number of looks that can still be taken; None: not limited.
    """

    sensors: tuple[SensorConfiguration, ...]
    visited: tuple[str, ...]
    robot: SensorPose
    belief: tuple[float, ...]
    rank: Callable[[], Ranking]
    forecast: Callable[[], Forecast]
    draw: Callable[[int], int]
    looks_left: int | None = None

    @property
    def unvisited(self) -> tuple[SensorConfiguration, ...]:
        """Sensor configurations from which the robot has not looked, in order."""
        return tuple(sensor for sensor in self.sensors if sensor.name not in self.visited)


@dataclass(frozen=True)
class Choice:
    """Decision of a policy.

    Attributes:
        sensor: name of the sensor configuration to look from; None: grasp now.
        ranking: the service's ranking, where the policy requested it.
    """

    sensor: str | None
    ranking: Ranking | None = None


@runtime_checkable
class Policy(Protocol):
    """Chooses looks. One policy serves one episode at a time and may keep state of it."""

    name: str

    def choose(self, situation: Situation, /) -> Choice:
        """Choose from where to look next, or to grasp."""


@dataclass
class HighestVoa:
    """The look, or pair of looks, that the service recommends; grasp where it recommends none."""

    name: str = "voa"
    _second: str | None = None

    def choose(self, situation: Situation) -> Choice:
        """Follow the service's recommendation, and take both looks of a pair as `voa_client.next_look` says."""
        ranking = situation.rank()
        look = next_look(ranking, self._second if situation.visited else None)
        if look is None or (look.then is not None and situation.looks_left == 1):  # a pair needs two looks
            return Choice(None, ranking)
        self._second = look.then
        return Choice(look.sensor, ranking)


@dataclass
class LeastEntropy:
    """The look after which the least entropy of the belief is expected, from each place once."""

    name: str = "entropy"
    _forecast: Forecast | None = None

    def choose(self, situation: Situation) -> Choice:
        """Choose by the entropy expected over predicted scans; of equal ones the first listed."""
        self._forecast = self._forecast or situation.forecast()
        return _smallest(situation, self._forecast.expected_entropies(situation.belief))


@dataclass
class MostBeams:
    """The look from which most beams are expected to meet the object, from each place once."""

    name: str = "beams"
    _forecast: Forecast | None = None

    def choose(self, situation: Situation) -> Choice:
        """Choose by the number of beams expected to meet the object; of equal ones the first listed."""
        self._forecast = self._forecast or situation.forecast()
        return _smallest(situation, -self._forecast.expected_beams(situation.belief))


@dataclass
class Nearest:
    """The look from the sensor configuration nearest to the robot, from each place once."""

    name: str = "nearest"

    def choose(self, situation: Situation) -> Choice:
        """Choose by the distance from the robot; of equal ones the first listed."""
        robot = situation.robot
        ordered = sorted(situation.unvisited, key=lambda sensor: math.hypot(sensor.x - robot.x, sensor.y - robot.y))
        return Choice(ordered[0].name if ordered else None)


@dataclass
class Random:
    """A look from any sensor configuration, each as likely, from each place once."""

    name: str = "random"

    def choose(self, situation: Situation) -> Choice:
        """Draw one of the sensor configurations that are left."""
        unvisited = situation.unvisited
        return Choice(unvisited[situation.draw(len(unvisited))].name if unvisited else None)


@dataclass
class NoLook:
    """No look at all: grasp at once."""

    name: str = "none"

    def choose(self, _situation: Situation) -> Choice:
        """Choose to grasp."""
        return Choice(None)


def _smallest(situation: Situation, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Choice:
    """The sensor configuration that is left with the smallest value; values (sensors,) that round to 9 digits tie."""
    rounded = dict(zip((sensor.name for sensor in situation.sensors), np.round(values, 9), strict=True))
    left = [sensor.name for sensor in situation.unvisited]
    return Choice(min(left, key=lambda name: float(rounded[name])) if left else None)


POLICIES: Mapping[str, str] = MappingProxyType(
    {
        "voa": "the look with the highest Value of Assistance; none if no look is worth more than min_gain",
        "entropy": "the look after which the least entropy is expected over predicted scans",
        "beams": "the look from which most beams are expected to meet the object",
        "nearest": "the look nearest to where the robot happens to be",
        "random": "any look, each as likely",
        "none": "no look: grasp at once",
    }
)
"""Descriptions of the built-in policies, by name."""

_BUILT_IN: Mapping[str, Callable[[], Policy]] = MappingProxyType(
    {
        "voa": HighestVoa,
        "entropy": LeastEntropy,
        "beams": MostBeams,
        "nearest": Nearest,
        "random": Random,
        "none": NoLook,
    }
)


def policy_named(name: str) -> Policy:
    """Make the policy of that name.

    Raises:
        UnknownName: there is no such policy; the message lists those that there are.
        InvalidPolicy: an installed package offers it, but it cannot be loaded or is no policy.
    """
    if name in _BUILT_IN:
        return _BUILT_IN[name]()
    installed = _installed()
    if name not in installed:
        raise UnknownName("policy", name, [*POLICIES, *installed])
    return _load(installed[name])


def description_of(name: str) -> str:
    """Return the description of a policy: of an installed one the first line of its docstring.

    Raises:
        UnknownName: there is no such policy.
        InvalidPolicy: it cannot be loaded, or is no policy.
    """
    if name in POLICIES:
        return POLICIES[name]
    lines = (policy_named(name).__doc__ or "").strip().splitlines()
    return lines[0].rstrip(".") if lines else f"the installed policy {name}"


def _installed() -> dict[str, EntryPoint]:
    """Entry points of installed packages by name; a built-in policy is never replaced."""
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in POLICIES}


def _load(point: EntryPoint) -> Policy:
    try:
        policy = point.load()()
    except Exception as error:  # code of an installed package may raise anything
        raise InvalidPolicy(f"policy {point.name!r} ({point.value}) cannot be loaded: {error}") from error
    if not isinstance(policy, Policy):
        raise InvalidPolicy(
            f"policy {point.name!r}: expected that {point.value} makes an object with `name` and `choose`, "
            f"got {type(policy).__name__}"
        )
    return policy
