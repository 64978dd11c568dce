"""Promised values of looks, over simulated scans and over exact scans, and the looks that follow from them."""

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.filtering import Belief
from voa_core.ranking import RankedLook, rank_looks
from voa_core.recommendation import Recommendation, recommend
from voa_evaluation.values.bench import Bench

SIMULATED, EXACT = "simulated", "exact"


@dataclass(frozen=True, eq=False)
class Promise:
    """Promised net values of the looks from k places, and the recommendation.

    Attributes:
        net: (k,) promised net values; over simulated scans those over the scans that all places share.
        best: index of the place with the largest net value; over simulated scans after the evaluation on fresh scans.
        best_net: promised net value of that place.
        recommended: True if its value surely exceeds the scenario's `min_gain`, so that the look is recommended.
    """

    net: Floats
    best: int
    best_net: float
    recommended: bool


def simulated_promise(bench: Bench, belief: Belief) -> Promise:
    """Rank and recommend over simulated scans, as the service does by default for scenarios with a spread."""
    valuation = bench.valuation(belief)
    ranking = rank_looks(bench.sensors, bench.simulated, valuation)
    recommendation = recommend(
        ranking, bench.simulated, valuation, fresh=bench.fresh, min_gain=bench.scenario.min_gain, lookahead=1
    )
    return _promise(bench, ranking.looks, recommendation)


def exact_promise(bench: Bench, belief: Belief) -> Promise:
    """Rank and recommend over one exact scan per pose, by the paper's definition of the Value of Assistance."""
    valuation = bench.exact_valuation(belief)
    ranking = rank_looks(bench.sensors, bench.exact, valuation)
    recommendation = recommend(ranking, bench.exact, valuation, min_gain=bench.scenario.min_gain, lookahead=1)
    return _promise(bench, ranking.looks, recommendation)


def _promise(bench: Bench, looks: tuple[RankedLook, ...], recommendation: Recommendation) -> Promise:
    by_name = {look.sensor.name: look.net_value for look in looks}
    names = [sensor.name for sensor in bench.sensors]
    first = recommendation.ranking.looks[0]
    return Promise(
        net=np.array([by_name[name] for name in names]),
        best=names.index(first.sensor.name),
        best_net=first.net_value,
        recommended=recommendation.look is not None,
    )
