"""Single looks where driving costs: net values of ways that count the drive, and of ways that do not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.looks import Driving
from voa_core.ranking import rank_looks
from voa_core.recommendation import recommend
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.cases import Case
from voa_evaluation.values.policies import NEAREST, RANDOM, VOA, distances_from
from voa_evaluation.values.promises import Promise
from voa_evaluation.values.samples import Gathering, Sample
from voa_evaluation.values.setting import DRIVING_COSTS
from voa_evaluation.values.truth import Truth, argmax

WITHOUT_COSTS = "voa without costs"


@dataclass(frozen=True, eq=False)
class Drive:
    """Looks of all cases by one way at one price of driving.

    Attributes:
        net: achieved value less the costs of the look and of the drive.
        metres: mean length of the drive.
        grasped: number of cases without a look.
        promised: mean promised net value; None for a way that promises nothing.
    """

    net: Sample
    metres: float
    grasped: int
    promised: float | None


def drives(
    bench: Bench, cases: Sequence[Case], truths: Sequence[Truth], promises: Sequence[Promise]
) -> Mapping[tuple[float, str], Drive]:
    """Value a look of every case by every way at every price of driving: by price per metre and way.

    Args:
        bench: the object, rule and robot error.
        cases: beliefs and starts.
        truths: achieved values of the looks in each case.
        promises: over simulated scans, in each case, without the costs of driving.
    """
    return {
        (cost, way): _drive(bench, cases, truths, promises, cost, way)
        for cost in DRIVING_COSTS
        for way in (VOA, WITHOUT_COSTS, NEAREST, RANDOM)
    }


def _drive(
    bench: Bench,
    cases: Sequence[Case],
    truths: Sequence[Truth],
    promises: Sequence[Promise],
    cost: float,
    way: str,
) -> Drive:
    gathered, metres, grasped, promised = Gathering(), [], 0, []
    for case, truth, promise in zip(cases, truths, promises, strict=True):
        away = distances_from(bench, case.start)
        if way == RANDOM:
            gathered.add(truth.shares, (truth.gains - cost * away[:, None, None]).mean(axis=0))
            metres.append(float(away.mean()))
            continue
        index: int | None
        if way == VOA:
            index, value = _with_costs(bench, case, cost)
            promised.append(value)
        elif way == NEAREST:
            index = argmax(-away)
        else:
            index = promise.best if promise.recommended else None
        if index is None:
            gathered.add(truth.shares, np.zeros_like(truth.gains[0]))
            metres.append(0.0)
            grasped += 1
        else:
            gathered.add(truth.shares, truth.gains[index] - cost * away[index])
            metres.append(float(away[index]))
    return Drive(gathered.sample(), float(np.mean(metres)), grasped, float(np.mean(promised)) if promised else None)


def _with_costs(bench: Bench, case: Case, cost: float) -> tuple[int | None, float]:
    """Recommended place with the costs of driving, None for a grasp, and its promised net value."""
    valuation, driving = bench.valuation(case.belief), Driving(*case.start, cost)
    advice = recommend(
        rank_looks(bench.sensors, bench.simulated, valuation, driving=driving),
        bench.simulated,
        valuation,
        fresh=bench.fresh,
        min_gain=bench.scenario.min_gain,
        lookahead=1,
        driving=driving,
    )
    if advice.look is None:
        return None, 0.0
    names = [sensor.name for sensor in bench.sensors]
    return names.index(advice.look.sensor.name), advice.net_value or 0.0
