"""Ranking of sensor configurations by net value, which is the Value of Assistance of a look less its cost."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol, TypeVar

import numpy as np

from voa_core.assistance import Assistance, Definition, Valuation
from voa_core.choices import LookWeights
from voa_core.filtering import Belief
from voa_core.grasps import Choice, GraspTable, best_grasp
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, Looks, cost_of, exact_looks
from voa_core.standard_errors import standard_error
from voa_core.updating import UpdatePolicy
from voa_core.weights import wanted

A = TypeVar("A")
B = TypeVar("B")

SAME_VALUE_DIGITS = 12
MIN_GAIN = 0.005
"""Net value that a look must exceed to be recommended, in success probability, unless a scenario says otherwise."""
_TIE = 1e-6
_ROUNDING = 1e-12


class OrderedMap(Protocol):
    """A function like `map`, which applies a function to items, perhaps on several threads."""

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterable[B]:
        """Apply `function` to each item; the results come in the order of the items."""


@dataclass(frozen=True, eq=False)
class RankedLook:
    """A look from a sensor configuration with its value.

    Attributes:
        sensor: the sensor configuration.
        assistance: Value of Assistance of the look.
        net_value: VOA less cost, in success probability.
        cost: of the look, with the drive to it where that costs something.
    """

    sensor: SensorConfiguration
    assistance: Assistance
    net_value: float
    cost: float

    @property
    def sure_net_value(self) -> float:
        """Net value less two standard errors; over exact scans the net value itself."""
        return self.net_value - 2.0 * (self.assistance.standard_error or 0.0)


@dataclass(frozen=True, eq=False)
class Ranking:
    """Looks by net value, the best first, and the best grasp without a look.

    Attributes:
        before: best grasp and its expected score under the belief before any look.
        looks: ordered by net value rounded to 1e-12, ties as listed. Over simulated scans the first, and others, may
            have the values of an evaluation of their own (`recommendation.recommend`).
        value_of_perfect_information: gain in success probability if the pose were known.
        compared: the looks, in this order, with the values that they have over the scans that all share.
        tied: the looks that tie with the first, where samples of the poses say so; None: `compared` says.
    """

    before: Choice
    looks: tuple[RankedLook, ...]
    value_of_perfect_information: float
    compared: tuple[RankedLook, ...]
    tied: frozenset[RankedLook] | None = None

    @classmethod
    def of(
        cls,
        before: Choice,
        looks: Sequence[RankedLook],
        value_of_perfect_information: float,
        tied: frozenset[RankedLook] | None = None,
    ) -> "Ranking":
        """Rank looks, in the order in which they are listed, whose values are over scans that all share."""
        ranked = tuple(looks[index] for index in order_by_net_value(looks))
        return cls(before, ranked, value_of_perfect_information, ranked, tied)

    def with_value(self, look: RankedLook, own: RankedLook) -> "Ranking":
        """Rank again with the values of an evaluation of its own for one of the looks."""
        looks = [own if each is look else each for each in self.looks]
        return replace(self, looks=tuple(looks))._in_order(order_by_net_value(looks))

    def with_first(self, look: RankedLook) -> "Ranking":
        """Move one of the looks to the first place."""
        index = self.looks.index(look)
        return self._in_order([index, *(each for each in range(len(self.looks)) if each != index)])

    def _in_order(self, order: Sequence[int]) -> "Ranking":
        return replace(
            self,
            looks=tuple(self.looks[index] for index in order),
            compared=tuple(self.compared[index] for index in order),
        )

    def worth_looking(self, min_gain: float = MIN_GAIN) -> bool:
        """True if the net value of the first look surely exceeds `min_gain`; otherwise a grasp is recommended.

        It surely does if it exceeds it by two standard errors; over exact scans the net value itself counts.
        """
        return self.looks[0].sure_net_value > min_gain

    def ties_with_first(self, look: RankedLook) -> bool:
        """True if the net values of `look` and of the first look do not differ; the first ties with itself.

        Over simulated scans they differ if their difference over the same samples exceeds two standard errors of it,
        over exact scans if it exceeds 1e-6.
        """
        index = self.looks.index(look)
        if index == 0 or self.tied is not None:
            return index == 0 or look in (self.tied or ())
        first, look = self.compared[0], self.compared[index]
        difference = first.net_value - look.net_value
        if look.assistance.standard_error is None:
            return difference <= _TIE
        gains = first.assistance.gains - look.assistance.gains
        return difference <= 2.0 * standard_error(look.assistance.shares, gains) + _ROUNDING


def order_by_net_value(looks: Sequence[RankedLook]) -> list[int]:
    """Indices of looks by net value, the largest first; those that are equal to 1e-12 stay in their order."""
    values = np.array([look.net_value for look in looks])
    return [int(i) for i in np.argsort(-np.round(values, SAME_VALUE_DIGITS), kind="stable")]


def rank(
    sensors: Sequence[SensorConfiguration],
    weigher_of: Callable[[SensorConfiguration], LookWeights],
    belief: Belief,
    table: GraspTable,
    policy: UpdatePolicy,
    *,
    definition: Definition = "posterior",
    sensor_belief: Belief | None = None,
    ordered_map: OrderedMap = map,
    check: Callable[[], None] = wanted,
) -> Ranking:
    """Rank sensor configurations by the net value of one exact scan under a belief.

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
    valuation = Valuation(belief, table, policy, definition, sensor_belief, check=check)
    return rank_looks(sensors, Looks(exact_looks(weigher_of)), valuation, ordered_map=ordered_map)


def rank_looks(
    sensors: Sequence[SensorConfiguration],
    looks: Looks,
    valuation: Valuation,
    *,
    driving: Driving | None = None,
    ordered_map: OrderedMap = map,
) -> Ranking:
    """Rank looks from sensor configurations by net value, on exact or simulated scans.

    Args:
        sensors: at least one.
        looks: gives the weights after the scans from a sensor configuration and from those where a look is pending.
        valuation: belief, grasps and definition.
        driving: costs of driving to a sensor configuration; None: driving costs nothing.
        ordered_map: `map`, or a function like it that works on several threads.
    """
    pending = looks.baseline()
    value = partial(value_look, looks=looks, valuation=valuation, pending=pending, driving=driving)
    return Ranking.of(
        best_grasp(valuation.table, valuation.belief.p),
        list(ordered_map(value, sensors)),
        valuation.perfect_information(pending),
    )


def value_look(
    sensor: SensorConfiguration,
    looks: Looks,
    valuation: Valuation,
    pending: LookWeights | None = None,
    driving: Driving | None = None,
) -> RankedLook:
    """Value one look from a sensor configuration; its answer does not depend on which others are ranked.

    Args:
        sensor: where the lidar would stand.
        looks: gives the weights after the scans from a sensor configuration and from those where a look is pending.
        valuation: belief, grasps and definition.
        pending: weights after the pending scans alone; None where nothing is pending.
        driving: costs of driving to the sensor configuration; None: driving costs nothing.
    """
    valuation.check()
    assistance = valuation.value(looks.together(sensor), pending)
    cost = cost_of([sensor], driving)
    return RankedLook(sensor, assistance, assistance.voa - cost, cost)
