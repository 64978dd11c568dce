"""Several looks that are planned together: repeated places, pairs, and two robots with looks under way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from voa_core.assistance import Assistance
from voa_core.filtering import Belief
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Looks
from voa_core.ranking import rank_looks
from voa_core.recommendation import recommend
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.cases import Case
from voa_evaluation.values.promises import Promise
from voa_evaluation.values.results import PairValue, Repetition
from voa_evaluation.values.samples import Gathering, Sample, normal_interval
from voa_evaluation.values.scans import random_source
from voa_evaluation.values.truth import argmax

MOST_LOOKS = 3
ANNOUNCED, UNAWARE, NEXT_BEST, TWO_RANDOM = "announced", "unaware", "next best", "random"


@dataclass(frozen=True, eq=False)
class TwoLooks:
    """Two looks at once in all cases, for one way in which the second robot chooses.

    Attributes:
        promised: mean value of both looks over simulated scans.
        gains: achieved value of both looks.
        same_place: number of cases in which both robots go to one place.
    """

    promised: float
    gains: Sample
    same_place: int


def _net(assistance: Assistance, sensors: Sequence[SensorConfiguration]) -> float:
    return assistance.voa - sum(sensor.cost for sensor in sensors)


def repetitions(bench: Bench, promise: Promise) -> list[Repetition]:
    """Compare scans from the best place with scans from the best places in turn, under the uniform belief.

    Args:
        bench: the object, rule and robot error.
        promise: over simulated scans, under the uniform belief.
    """
    valuation = bench.valuation(Belief.uniform(len(bench.scenario.poses)))
    order = sorted(range(len(bench.sensors)), key=lambda index: -round(float(promise.net[index]), 12))
    rows = []
    for looks in range(1, min(MOST_LOOKS, len(order)) + 1):
        for name, chosen in (("one", [order[0]] * looks), ("different", order[:looks])):
            sensors = [bench.sensors[index] for index in chosen]
            promised = valuation.value(bench.fresh.together(*sensors))
            achieved = valuation.value(bench.taken.together(*sensors))
            interval = normal_interval(achieved.voa, achieved.standard_error or 0.0, achieved.gains.size)
            rows.append(Repetition(bench.object, bench.rule, bench.error.name, name, looks, promised.voa, interval))
    return rows


def best_pair(bench: Bench, single: Promise) -> PairValue:
    """Compare the best pair of places with the best single place, under the uniform belief.

    Args:
        bench: the object, rule and robot error.
        single: promise over simulated scans, under the uniform belief.
    """
    valuation = bench.valuation(Belief.uniform(len(bench.scenario.poses)))
    advice = recommend(
        rank_looks(bench.sensors, bench.simulated, valuation),
        bench.simulated,
        valuation,
        fresh=bench.fresh,
        min_gain=bench.scenario.min_gain,
    )
    pairs = list(combinations(bench.sensors, 2))
    pair = max(pairs, key=lambda each: round(_net(valuation.value(bench.simulated.together(*each)), each), 12))
    alone = (bench.sensors[single.best],)
    values = {}
    for name, sensors in (("single", alone), ("pair", pair)):
        taken = valuation.value(bench.taken.together(*sensors))
        promised = _net(valuation.value(bench.fresh.together(*sensors)), sensors)
        achieved = normal_interval(_net(taken, sensors), taken.standard_error or 0.0, taken.gains.size)
        values[name] = promised, achieved
    return PairValue(
        object=bench.object,
        robot_error=bench.error.name,
        recommended="grasp" if advice.look is None else "look" if advice.then is None else "pair",
        single=alone[0].name,
        pair=" + ".join(sensor.name for sensor in pair),
        single_promised=values["single"][0],
        pair_promised=values["pair"][0],
        single_achieved=values["single"][1],
        pair_achieved=values["pair"][1],
    )


def two_robots(
    bench: Bench, cases: Sequence[Case], promises: Sequence[Promise], scans: int, seed: int
) -> Mapping[str, TwoLooks]:
    """Value two looks at once by two robots, whose errors differ even at one place.

    Args:
        bench: the object, rule and robot error.
        cases: beliefs.
        promises: over simulated scans, in each case.
        scans: number of the world's scans of each pose.
        seed: of the random places.
    """
    taken = bench.taken_by((0, 1), scans)
    gathered: dict[str, Gathering] = {}
    promised: dict[str, float] = {}
    same: dict[str, int] = {}
    for case, promise in zip(cases, promises, strict=True):
        rng = random_source(seed, "two robots", bench.object, case.kind, case.index)
        valuation = bench.valuation(case.belief)
        for way, places in _places_of_two(bench, case, promise, [int(i) for i in rng.permutation(len(bench.sensors))]):
            sensors = [bench.sensors[index] for index in places]
            assistance = valuation.value(taken.together(*sensors))
            gathered.setdefault(way, Gathering()).add(case.belief.p[assistance.outcomes], assistance.gains)
            promised[way] = promised.get(way, 0.0) + valuation.value(bench.fresh.together(*sensors)).voa / len(cases)
            same[way] = same.get(way, 0) + (places[0] == places[1])
    return {way: TwoLooks(promised[way], own.sample(), same[way]) for way, own in gathered.items()}


def _places_of_two(
    bench: Bench, case: Case, promise: Promise, shuffled: Sequence[int]
) -> list[tuple[str, tuple[int, int]]]:
    """Indices of the places of both robots, by the way in which the second one chooses."""
    first = promise.best
    names = [sensor.name for sensor in bench.sensors]
    pending: Looks = replace(bench.simulated, pending=(bench.sensors[first],))
    ranking = rank_looks(bench.sensors, pending, bench.valuation(case.belief))
    left = promise.net.copy()
    left[first] = -float("inf")
    return [
        (ANNOUNCED, (first, names.index(ranking.looks[0].sensor.name))),
        (UNAWARE, (first, first)),
        (NEXT_BEST, (first, argmax(left))),
        (TWO_RANDOM, (shuffled[0], shuffled[1])),
    ]
