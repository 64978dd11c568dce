"""Single looks at one bench: every case's promises, choices and achieved values, gathered for the tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_evaluation.values.bench import Bench
from voa_evaluation.values.cases import Case
from voa_evaluation.values.measures import Order, order_agreement, tau_of_oracle, tau_of_promise
from voa_evaluation.values.policies import ORACLE, RANDOM, VOA, VOA_EXACT, chosen_without_value
from voa_evaluation.values.promises import EXACT, SIMULATED, Promise, exact_promise
from voa_evaluation.values.samples import Gathering, Sample
from voa_evaluation.values.scans import random_source
from voa_evaluation.values.truth import Truth, crossed, oracle_choices

WORST = "worst"


@dataclass(frozen=True, eq=False)
class JudgedPromise:
    """A promise for one case beside what was achieved.

    Attributes:
        promise: the promised values.
        achieved, errors: (k,) achieved net values of the places and their standard errors.
        chosen_error: promised less achieved net value of the chosen place.
        tau: of promised and achieved values; None where there is no order.
        tau_oracle: that the true values would reach.
        order: partial-order agreement.
    """

    promise: Promise
    achieved: Floats
    errors: Floats
    chosen_error: float
    tau: float | None
    tau_oracle: float | None
    order: Order


@dataclass(frozen=True, eq=False)
class SingleLooks:
    """Looks of all cases of one kind of belief, at one object, under one rule, with one robot error.

    Attributes:
        object, rule, robot_error: as in `results`.
        sensors: names of the places.
        kind: of the beliefs.
        judged: for each kind of promise, one for each case.
        gains: of each way of choosing, of `oracle` and of `worst`.
        chosen_errors: for each kind of promise, promised less achieved value of the chosen look.
        grasped: number of cases without a look, by way.
        without: mean success without a look.
        scans: number of the world's scans, over all places.
    """

    object: str
    rule: str
    robot_error: str
    sensors: tuple[str, ...]
    kind: str
    judged: Mapping[str, tuple[JudgedPromise, ...]]
    gains: Mapping[str, Sample]
    chosen_errors: Mapping[str, Sample]
    grasped: Mapping[str, int]
    without: float
    scans: int


def evaluate_single_looks(
    bench: Bench, cases: Sequence[Case], truths: Sequence[Truth], simulated: Sequence[Promise], seed: int
) -> SingleLooks:
    """Evaluate one look in every case.

    Args:
        bench: the object, rule and robot error.
        cases: of one kind of belief.
        truths: achieved values of the looks in each case.
        simulated: promised values over simulated scans in each case.
        seed: of the resampling.
    """
    gains: dict[str, Gathering] = {}
    errors: dict[str, Gathering] = {}
    judged: dict[str, list[JudgedPromise]] = {SIMULATED: [], EXACT: []}
    grasped: dict[str, int] = {}
    for case, truth, promise_simulated in zip(cases, truths, simulated, strict=True):
        promises = {SIMULATED: promise_simulated, EXACT: exact_promise(bench, case.belief)}
        rng = random_source(seed, "resampling", bench.object, bench.rule, bench.error.name, case.kind, case.index)
        tau_oracle = tau_of_oracle(truth, rng)
        for name, promise in promises.items():
            judged[name].append(_judged(promise, truth, tau_oracle))
            apart = promise.best_net - truth.gains[promise.best]
            errors.setdefault(name, Gathering()).add(truth.shares, apart)
        for way, gain in _gains_of_ways(bench, case, truth, promises, grasped).items():
            gains.setdefault(way, Gathering()).add(truth.shares, gain)
    return SingleLooks(
        object=bench.object,
        rule=bench.rule,
        robot_error=bench.error.name,
        sensors=tuple(sensor.name for sensor in bench.sensors),
        kind=cases[0].kind,
        judged={name: tuple(own) for name, own in judged.items()},
        gains={way: gathering.sample() for way, gathering in gains.items()},
        chosen_errors={name: gathering.sample() for name, gathering in errors.items()},
        grasped=grasped,
        without=float(np.mean([truth.without for truth in truths])),
        scans=truths[0].gains.size,
    )


def _judged(promise: Promise, truth: Truth, tau_oracle: float | None) -> JudgedPromise:
    achieved = truth.net
    return JudgedPromise(
        promise=promise,
        achieved=achieved,
        errors=np.sqrt(np.diagonal(truth.covariance())),
        chosen_error=promise.best_net - float(achieved[promise.best]),
        tau=tau_of_promise(promise.net, truth),
        tau_oracle=tau_oracle,
        order=order_agreement(promise.net, truth),
    )


def _gains_of_ways(
    bench: Bench, case: Case, truth: Truth, promises: Mapping[str, Promise], grasped: dict[str, int]
) -> dict[str, Floats]:
    """Gain (n, S) of every way of choosing; counts in `grasped` the cases in which a way takes no look."""
    gains: dict[str, Floats] = {}
    for way, promise in ((VOA, promises[SIMULATED]), (VOA_EXACT, promises[EXACT])):
        gains[way] = truth.gains[promise.best] if promise.recommended else np.zeros_like(truth.gains[0])
        grasped[way] = grasped.get(way, 0) + (not promise.recommended)
    for way, index in chosen_without_value(bench, case.belief, case.start).items():
        gains[way] = truth.gains[index]
    gains[RANDOM] = truth.gains.mean(axis=0)
    best, worst = oracle_choices(truth)
    gains[ORACLE], gains[WORST] = crossed(truth, best), crossed(truth, worst)
    return gains
