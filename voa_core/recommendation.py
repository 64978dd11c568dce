"""Recommendation: look, look from two places one after the other, or grasp.

Two looks may be worth nothing alone and much together, so pairs count where no single look is worth its cost and
perfect information is. The best of many values was partly lucky, so over simulated scans the best look and the best
pair are evaluated once more, on four times as many other scans. A look that falls behind by its own evaluation leaves
its place to the next, until the first look has values of its own.
"""

from dataclasses import dataclass, replace
from itertools import combinations

from voa_core.assistance import Assistance, Valuation
from voa_core.choices import LookWeights
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, LookOf, Looks, cost_of
from voa_core.ranking import MIN_GAIN, OrderedMap, RankedLook, Ranking

MOST_PLACES_IN_PAIRS = 64
_MOST_PAIR_BYTES = 2**30
_MOST_EVALUATED = 8


@dataclass(frozen=True, eq=False)
class Pair:
    """Two looks one after the other.

    Attributes:
        first: the one with the larger net value alone.
        then: the other.
        assistance: Value of Assistance of both together.
        net_value: of both together, less both costs.
    """

    first: RankedLook
    then: RankedLook
    assistance: Assistance
    net_value: float

    @property
    def sure_net_value(self) -> float:
        """Net value less two standard errors; over exact scans the net value itself."""
        return self.net_value - 2.0 * (self.assistance.standard_error or 0.0)


@dataclass(frozen=True, eq=False)
class Recommendation:
    """Advice after a ranking.

    Attributes:
        ranking: with the values of the first look's own evaluation, where it had one.
        look: the look to take next; None: grasp.
        then: the look to take after it, where two looks are worth it only together.
        net_value: of the look, or of both; None: grasp.
        standard_error: of the net value; None over exact scans, and for a grasp.
        lookahead: 2 if pairs of looks would have been considered, else 1.
    """

    ranking: Ranking
    look: RankedLook | None
    then: RankedLook | None
    net_value: float | None
    standard_error: float | None
    lookahead: int


def recommend(
    ranking: Ranking,
    looks: Looks,
    valuation: Valuation,
    *,
    fresh: Looks | None = None,
    min_gain: float = MIN_GAIN,
    lookahead: int = 2,
    driving: Driving | None = None,
    ordered_map: OrderedMap = map,
) -> Recommendation:
    """Recommend a look, two looks, or a grasp.

    Args:
        ranking: of the looks, from `rank_looks` with the arguments below.
        looks: gives the weights after scans from sensor configurations.
        valuation: belief, grasps and definition.
        fresh: gives weights over other and more simulated scans; None: scans are exact.
        min_gain: net value that looks must exceed, in success probability.
        lookahead: 1: single looks alone; 2: pairs too, for at most 64 places.
        driving: costs of driving to the places and between them.
        ordered_map: `map`, or a function like it that works on several threads.
    """
    places = len(ranking.looks)
    lookahead = 2 if lookahead >= 2 and 2 <= places <= MOST_PLACES_IN_PAIRS and _fits(ranking) else 1
    shared = ranking
    if fresh is not None:
        ranking = _with_own_values(ranking, fresh, valuation)
    best = ranking.looks[0]
    if ranking.worth_looking(min_gain):
        return Recommendation(ranking, best, None, best.net_value, best.assistance.standard_error, lookahead)
    pair = _best_pair(shared, looks, valuation, min_gain, driving, ordered_map) if lookahead == 2 else None
    if pair is not None and fresh is not None:
        pair = _valued(pair.first, pair.then, fresh, valuation, fresh.baseline(), driving)
    if pair is not None and pair.sure_net_value > min_gain:
        error = pair.assistance.standard_error
        return Recommendation(ranking, pair.first, pair.then, pair.net_value, error, lookahead)
    return Recommendation(ranking, None, None, None, None, lookahead)


def _fits(ranking: Ranking) -> bool:
    """True if the weights of all places, which pairs need at once, take at most 1 GiB."""
    gains = ranking.looks[0].assistance.gains
    return 8 * len(ranking.looks) * gains.size * len(gains) <= _MOST_PAIR_BYTES


def _with_own_values(ranking: Ranking, fresh: Looks, valuation: Valuation) -> Ranking:
    """Evaluate the first look of a ranking on other scans, so that it is not the best by luck, until it stays first.

    Of many looks that hardly differ, a few are evaluated, and the best of these goes first.
    """
    pending = fresh.baseline()
    evaluated: list[RankedLook] = []
    while ranking.looks[0] not in evaluated and len(evaluated) < _MOST_EVALUATED:
        first = ranking.looks[0]
        assistance = valuation.value(fresh.together(first.sensor), pending)
        evaluated.append(replace(first, assistance=assistance, net_value=assistance.voa - first.cost))
        ranking = ranking.with_value(first, evaluated[-1])
    return ranking.with_first(next(look for look in ranking.looks if look in evaluated))


def _best_pair(
    ranking: Ranking,
    looks: Looks,
    valuation: Valuation,
    min_gain: float,
    driving: Driving | None,
    ordered_map: OrderedMap,
) -> Pair | None:
    """Best pair of looks, by net value and then as ranked; None where perfect information is worth no pair's cost.

    An executed value never exceeds that of perfect information, so pairs that cannot gain enough are left out.
    """
    most = ranking.value_of_perfect_information - (min_gain if valuation.definition == "executed" else 0.0)
    pairs = [
        (first, then)
        for first, then in combinations(ranking.looks, 2)
        if most > cost_of([first.sensor, then.sensor], driving) and not looks.same_place(first.sensor, then.sensor)
    ]
    if not pairs:
        return None
    kept = replace(looks, of=_remembered(looks.of, valuation))
    pending = kept.baseline()

    def valued(pair: tuple[RankedLook, RankedLook]) -> Pair:
        valuation.check()
        return _valued(*pair, kept, valuation, pending, driving)

    return max(ordered_map(valued, pairs), key=lambda pair: round(pair.net_value, 12))


def _valued(
    first: RankedLook,
    then: RankedLook,
    looks: Looks,
    valuation: Valuation,
    pending: LookWeights | None,
    driving: Driving | None,
) -> Pair:
    assistance = valuation.value(looks.together(first.sensor, then.sensor), pending)
    return Pair(first, then, assistance, assistance.voa - cost_of([first.sensor, then.sensor], driving))


def _remembered(look_of: LookOf, valuation: Valuation) -> LookOf:
    """Make a function that computes the weights after scans from a sensor configuration once, and keeps them."""
    kept: dict[tuple[SensorConfiguration, int], LookWeights] = {}

    def of(sensor: SensorConfiguration, scans: int) -> LookWeights:
        if (sensor, scans) not in kept:
            kept[sensor, scans] = look_of(sensor, scans).seen_with(valuation.belief, valuation.policy)
        return kept[sensor, scans]

    return of
