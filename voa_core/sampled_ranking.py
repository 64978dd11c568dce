"""Ranking of looks over samples of the poses, for scenarios with too many poses and places to sum over all of them.

By successive halving: all places are valued over a small sample of the poses, the same for all of them; those that may
still be the best, a quarter of them at most, over a sample four times as large; and so on. An outcome of each sampled
pose is weighed with all poses, so a value over a sample is unbiased, and its error is only that of the sample.

A place that is left behind keeps what it lacked to the best place of that round, over the sample that they shared. Its
final value is that of this other place, which is valued over a larger sample, less the difference: so it stays behind,
and where the two values rise and fall together with the sample, it is much surer than over the small sample alone.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from voa_core.assistance import Valuation
from voa_core.choices import LookWeights
from voa_core.errors import InvalidInput
from voa_core.grasps import best_grasp
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, Looks
from voa_core.pose_samples import PoseSample, order_by_best_score
from voa_core.ranking import OrderedMap, RankedLook, Ranking, order_by_net_value, value_look

SAMPLE_SIZES = (64, 256, 1024)
_FEWEST_KEPT = 8
_SHARE_KEPT = 4
_PARTED = 3.0  # standard errors of the difference by which a place lies behind the best for good
_TIED = 2.0
_ROUNDING = 1e-6  # of the difference of two values in float32

Progress = Callable[[int, int], None]
"""A function that takes how many looks are valued, and of how many in the present round."""


@dataclass(frozen=True, eq=False)
class _Round:
    """Values of looks over one sample that they share.

    Attributes:
        sample: of the poses.
        values: of each look, by the index of its sensor configuration.
    """

    sample: PoseSample
    values: dict[int, RankedLook]

    def difference(self, one: int, other: int) -> tuple[float, float]:
        """Net value of a look less that of another, with its standard error over the sample."""
        first, then = self.values[one], self.values[other]
        gains = (first.assistance.gains - then.assistance.gains).mean(axis=1)
        return first.net_value - then.net_value, self.sample.standard_error(gains)

    @cached_property
    def ranked(self) -> list[int]:
        """Indices of the looks by net value, the best first."""
        indices = list(self.values)
        return [indices[place] for place in order_by_net_value(list(self.values.values()))]

    @property
    def best(self) -> int:
        """Index of the best look of the round."""
        return self.ranked[0]

    def near_the_best(self) -> list[int]:
        """Indices of the looks that may be the best, the best first, at most a quarter of them unless they are few."""
        near = [index for index in self.ranked if self._may_be_best(index)]
        return near[: max(_FEWEST_KEPT, len(self.ranked) // _SHARE_KEPT)]

    def _may_be_best(self, index: int) -> bool:
        ahead, error = self.difference(self.best, index)
        return ahead <= _PARTED * error + _ROUNDING


def rank_over_samples(
    sensors: Sequence[SensorConfiguration],
    looks: Looks,
    valuation: Valuation,
    *,
    seed: str,
    sizes: Sequence[int] = SAMPLE_SIZES,
    driving: Driving | None = None,
    ordered_map: OrderedMap = map,
    progress: Progress | None = None,
) -> Ranking:
    """Rank looks from sensor configurations by net value over samples of the poses.

    Equal arguments give equal rankings, whatever `ordered_map` does at the same time.

    Args:
        sensors: at least one.
        looks: gives the weights after the scans from a sensor configuration and from those where a look is pending.
        valuation: belief, grasps and definition.
        seed: names the samples.
        sizes: numbers of poses of the samples, ascending; one that is not below the number of possible poses means all
            of them.
        driving: costs of driving to a sensor configuration; None: driving costs nothing.
        ordered_map: `map`, or a function like it that works on several threads or machines.
        progress: called after each value.

    Raises:
        InvalidInput: there is no size, or they do not ascend.
    """
    pending = looks.baseline()
    rounds: list[_Round] = []
    left = list(range(len(sensors)))
    for sample in _samples(valuation, seed, sizes):
        values = values_over(
            [sensors[index] for index in left], looks, valuation, sample, pending, driving, ordered_map, progress
        )
        rounds.append(_Round(sample, dict(zip(left, values, strict=True))))
        left = rounds[-1].near_the_best()
    ranked, tied = _together(rounds)
    largest = replace(valuation, sample=rounds[-1].sample)
    before = best_grasp(valuation.table, valuation.belief.p)
    return Ranking.of(before, ranked, largest.perfect_information(pending), tied)


def values_over(
    sensors: Sequence[SensorConfiguration],
    looks: Looks,
    valuation: Valuation,
    sample: PoseSample,
    pending: LookWeights | None = None,
    driving: Driving | None = None,
    ordered_map: OrderedMap = map,
    progress: Progress | None = None,
) -> list[RankedLook]:
    """Value looks from some sensor configurations over a sample of the poses; each value is independent of the others.

    Args:
        sensors: where the lidar would stand.
        looks: gives the weights after the scans from a sensor configuration and from those where a look is pending.
        valuation: belief, grasps and definition.
        sample: of the poses.
        pending: weights after the pending scans alone; None where nothing is pending.
        driving: costs of driving to a sensor configuration; None: driving costs nothing.
        ordered_map: `map`, or a function like it that works on several threads or machines.
        progress: called after each value.
    """
    over_sample = replace(valuation, sample=sample)
    value = partial(value_look, looks=looks, valuation=over_sample, pending=pending, driving=driving)
    values = []
    for look in ordered_map(value, sensors):
        values.append(look)
        if progress is not None:
            progress(len(values), len(sensors))
    return values


def _samples(valuation: Valuation, seed: str, sizes: Sequence[int]) -> Iterator[PoseSample]:
    """Draw the samples of the rounds; the last is the first that has all possible poses, if there is one."""
    if len(sizes) == 0 or any(one >= then for one, then in pairwise(sizes)):
        raise InvalidInput("sizes", "at least one, ascending", str(list(sizes)))
    outer = valuation.outer
    possible = np.count_nonzero(outer)
    order = order_by_best_score(valuation.table, outer)
    for size in sizes:
        yield PoseSample.of(outer, order, size, seed)
        if size >= possible:
            return


def _together(rounds: Sequence[_Round]) -> tuple[list[RankedLook], frozenset[RankedLook]]:
    """Put the values of all rounds together: the looks as they were listed, and those that tie with the best.

    A look lies behind the best one of the last round that it is in, which lies behind that of its own last round.
    """
    behind: dict[int, float] = {}
    errors: dict[int, float] = {}
    looks: dict[int, RankedLook] = {}
    first = rounds[-1].values[rounds[-1].best]
    for each in reversed(rounds):
        before = (behind[each.best], errors[each.best]) if behind else (0.0, 0.0)
        for index in each.values.keys() - behind.keys():
            difference, error = each.difference(each.best, index)
            behind[index], errors[index] = before[0] + difference, math.hypot(before[1], error)
            look = each.values[index]
            looks[index] = look if each is rounds[-1] else _behind(look, first, behind[index], errors[index])
    tied = (looks[index] for index in looks if behind[index] <= _TIED * errors[index] + _ROUNDING)
    return [looks[index] for index in sorted(looks)], frozenset(tied)


def _behind(look: RankedLook, first: RankedLook, behind: float, error: float) -> RankedLook:
    """Give a look the net value of the first less a difference with a standard error of its own."""
    net_value = first.net_value - behind
    shift = net_value - look.net_value
    assistance = replace(
        look.assistance,
        voa=look.assistance.voa + shift,
        expected_score_after=look.assistance.expected_score_after + shift,
        standard_error=math.hypot(error, first.assistance.standard_error or 0.0),
    )
    return replace(look, assistance=assistance, net_value=net_value)
