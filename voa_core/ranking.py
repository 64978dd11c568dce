"""Ranking of sensor configurations by net value, which is the Value of Assistance of a look less its cost."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from voa_core.assistance import Assistance, Definition, value_of_assistance
from voa_core.filtering import Belief
from voa_core.grasps import Choice, GraspTable, best_grasp
from voa_core.lidars import SensorConfiguration
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher, wanted

A = TypeVar("A")
B = TypeVar("B")

SAME_VALUE_DIGITS = 12
MIN_GAIN = 0.005
"""Net value that a look must exceed to be recommended, in success probability, unless a scenario says otherwise."""
_TIE = 1e-6


class OrderedMap(Protocol):
    """A function like `map`, which applies a function to items, perhaps on several threads."""

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterable[B]:
        """Apply `function` to each item; the results come in the order of the items."""


@dataclass(frozen=True, eq=False)
class RankedLook:
    """A look from a sensor configuration with its value; `net_value` is VOA less cost, in success probability."""

    sensor: SensorConfiguration
    assistance: Assistance
    net_value: float


@dataclass(frozen=True, eq=False)
class Ranking:
    """Looks by net value, the best first, and the best grasp without a look.

    Attributes:
        before: best grasp and its expected score under the belief before any look.
        looks: ordered by net value rounded to 1e-12, ties as listed.
    """

    before: Choice
    looks: tuple[RankedLook, ...]

    def worth_looking(self, min_gain: float = MIN_GAIN) -> bool:
        """True if the net value of the first look exceeds `min_gain`; otherwise a grasp is recommended."""
        return self.looks[0].net_value > min_gain

    def ties_with_first(self, look: RankedLook) -> bool:
        """True if the net values of `look` and of the first look differ by at most 1e-6; the first ties with itself."""
        return self.looks[0].net_value - look.net_value <= _TIE


def rank(
    sensors: Sequence[SensorConfiguration],
    weigher_of: Callable[[SensorConfiguration], Weigher],
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    definition: Definition = "posterior",
    sensor_belief: Belief | None = None,
    ordered_map: OrderedMap = map,
    check: Callable[[], None] = wanted,
) -> Ranking:
    """Rank sensor configurations by net value under a belief.

    Args:
        sensors: at least one.
        weigher_of: gives the weights between the scans predicted at a sensor configuration.
        belief: of the gripper agent.
        table: the grasps that are reachable.
        policy: effect of a scan that no possible pose explains.
        definition: of VOA, see `assistance`.
        sensor_belief: of the sensor agent, where it differs.
        ordered_map: `map`, or a function like it that works on several threads.
        check: called between sensors, predictions and blocks of weights; an error that it raises ends the ranking.
    """

    def worth(sensor: SensorConfiguration) -> RankedLook:
        check()
        weigher = weigher_of(sensor)
        assistance = value_of_assistance(
            weigher, belief, table, policy, definition=definition, sensor_belief=sensor_belief, check=check
        )
        return RankedLook(sensor, assistance, assistance.voa - sensor.cost)

    looks = list(ordered_map(worth, sensors))
    order = np.argsort([-np.round(look.net_value, SAME_VALUE_DIGITS) for look in looks], kind="stable")
    return Ranking(best_grasp(table, belief.p), tuple(looks[index] for index in order))
