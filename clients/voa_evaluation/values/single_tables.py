"""Tables of single looks: promises, reliability, ways of choosing, and their differences."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from voa_core.checks import Floats
from voa_evaluation.statistics import Interval, bootstrap_mean, bootstrap_ratio
from voa_evaluation.values.policies import ORACLE, RANDOM, VOA, WAYS
from voa_evaluation.values.promises import EXACT, SIMULATED
from voa_evaluation.values.results import ALL, Bin, Difference, LookValue, Promise, WayValue
from voa_evaluation.values.samples import SHOWN, interval_of, mean_of, normal_interval, ratio_of, standard_error_of
from voa_evaluation.values.single_looks import WORST, JudgedPromise, SingleLooks

EDGES = (-1.0, 0.005, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1.0)
"""Edges of the bins of the reliability diagram, in success probability; a bin includes its lower edge."""


def grouped(looks: Sequence[SingleLooks]) -> list[tuple[str, list[SingleLooks]]]:
    """Group looks of one rule, robot error and kind of belief: each object alone, and all where there are several."""
    alone = [(each.object, [each]) for each in looks]
    return [(ALL, list(looks)), *alone] if len(looks) > 1 else alone


def look_values(looks: SingleLooks) -> list[LookValue]:
    """Make a row for each place under the uniform belief."""
    simulated, exact = looks.judged[SIMULATED][0], looks.judged[EXACT][0]
    scans = looks.scans // len(looks.sensors)
    return [
        LookValue(
            object=looks.object,
            rule=looks.rule,
            robot_error=looks.robot_error,
            sensor=sensor,
            simulated=float(simulated.promise.net[index]),
            exact=float(exact.promise.net[index]),
            achieved=normal_interval(float(simulated.achieved[index]), float(simulated.errors[index]), scans),
            without=looks.without,
        )
        for index, sensor in enumerate(looks.sensors)
    ]


def promise_rows(looks: Sequence[SingleLooks], seed: int) -> list[Promise]:
    """Compare promised with achieved values, for looks of one rule, robot error and kind of belief."""
    return [_promise_row(name, own, promise, seed) for name, own in grouped(looks) for promise in (SIMULATED, EXACT)]


def _promise_row(name: str, looks: Sequence[SingleLooks], promise: str, seed: int) -> Promise:
    strata = [each.judged[promise] for each in looks]
    judged = [one for stratum in strata for one in stratum]
    apart = np.concatenate([one.promise.net - one.achieved for one in judged])
    noise = np.concatenate([one.errors for one in judged])
    chosen = np.array([one.chosen_error for one in judged])
    error = interval_of([each.chosen_errors[promise] for each in looks])
    promised = float(np.mean([np.mean([one.promise.best_net for one in stratum]) for stratum in strata]))
    sure = np.array([one.order.sure for one in judged], dtype=np.float64)
    alike = np.array([one.order.alike for one in judged])
    first = looks[0]
    return Promise(
        object=name,
        rule=first.rule,
        robot_error=first.robot_error,
        belief=looks[0].kind,
        promise=promise,
        rms=_rms(apart),
        rms_noise=_rms(noise),
        looks=len(apart),
        promised=promised,
        achieved=promised - error.value,
        chosen=len(judged),
        rms_chosen=_rms(chosen),
        error_chosen=error,
        tau=_mean_tau([[one.tau for one in stratum] for stratum in strata], seed),
        tau_oracle=_mean_tau([[one.tau_oracle for one in stratum] for stratum in strata], seed),
        order=bootstrap_ratio(alike, sure, seed) if sure.sum() else None,
        pairs=sum(one.order.pairs for one in judged),
    )


def _mean_tau(strata: Sequence[Sequence[float | None]], seed: int) -> Interval | None:
    known = [np.array([tau for tau in stratum if tau is not None]) for stratum in strata]
    if not any(len(stratum) for stratum in known):
        return None
    several = all(len(stratum) > 1 for stratum in known)
    return bootstrap_mean(known if several else [np.concatenate(known)], seed)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def bin_rows(looks: Sequence[SingleLooks], seed: int) -> list[Bin]:
    """Put the looks of one rule and robot error, of all objects and kinds of belief, into bins of promised value."""
    rows = []
    for promise in (SIMULATED, EXACT):
        judged = [one for each in looks for one in each.judged[promise]]
        for low, high in pairwise(EDGES):
            row = _bin(looks[0], promise, judged, (low, high), seed)
            if row is not None:
                rows.append(row)
    return rows


def _bin(
    looks: SingleLooks, promise: str, judged: Sequence[JudgedPromise], edges: tuple[float, float], seed: int
) -> Bin | None:
    inside = [(one.promise.net >= edges[0]) & (one.promise.net < edges[1]) for one in judged]
    counts = np.array([int(flags.sum()) for flags in inside], dtype=np.float64)
    if not counts.sum():
        return None
    gained = np.array([one.achieved[flags].sum() for one, flags in zip(judged, inside, strict=True)])
    promised = sum(float(one.promise.net[flags].sum()) for one, flags in zip(judged, inside, strict=True))
    return Bin(
        rule=looks.rule,
        robot_error=looks.robot_error,
        promise=promise,
        low=edges[0],
        high=edges[1],
        promised=promised / float(counts.sum()),
        achieved=bootstrap_ratio(gained, counts, seed),
        cases=int((counts > 0).sum()),
    )


def way_rows(looks: Sequence[SingleLooks]) -> list[WayValue]:
    """Value every way of choosing, for looks of one rule, robot error and kind of belief."""
    return [_way_row(name, own, way) for name, own in grouped(looks) for way in (*WAYS, ORACLE)]


def _way_row(name: str, looks: Sequence[SingleLooks], way: str) -> WayValue:
    own, mean, best, worst = ([each.gains[each_way] for each in looks] for each_way in (way, RANDOM, ORACLE, WORST))
    lead = [a - b for a, b in zip(best, mean, strict=True)]
    won = [a - b for a, b in zip(own, mean, strict=True)]
    missed = [a - b for a, b in zip(best, own, strict=True)]
    range_ = [a - b for a, b in zip(best, worst, strict=True)]
    gain, without = interval_of(own), float(np.mean([each.without for each in looks]))
    first = looks[0]
    return WayValue(
        object=name,
        rule=first.rule,
        robot_error=first.robot_error,
        belief=looks[0].kind,
        way=way,
        without=without,
        gain=gain,
        success=without + gain.value,
        share=ratio_of(won, lead),
        regret=ratio_of(missed, range_),
        grasped=sum(each.grasped.get(way, 0) for each in looks),
        scans=sum(each.scans for each in looks),
    )


def difference_rows(looks: Sequence[SingleLooks]) -> list[Difference]:
    """Compare VOA over simulated scans with every other way, for looks of one rule, robot error and kind of belief."""
    others = [way for way in (*WAYS, ORACLE) if way != VOA]
    return [_difference(name, own, way) for name, own in grouped(looks) for way in others]


def _difference(name: str, looks: Sequence[SingleLooks], way: str) -> Difference:
    apart = [each.gains[VOA] - each.gains[way] for each in looks]
    difference = interval_of(apart)
    first = looks[0]
    return Difference(
        object=name,
        rule=first.rule,
        robot_error=first.robot_error,
        belief=looks[0].kind,
        way=way,
        difference=difference,
        sure=difference.excludes_zero and mean_of(apart) != 0.0,
        smallest=SHOWN * standard_error_of(apart),
    )
