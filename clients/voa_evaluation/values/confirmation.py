"""Confirmation of promised values by end-to-end drops in MuJoCo: lidar, update, grasp, lift.

A simulated lidar scans the dropped object in a room, the update rule `beam` weighs the scan, and a simulated arm
attempts the best grasp. A robot error of 1 cm and 1 degree and the object's spread are stated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from voa_core.estimates import Estimate
from voa_core.filtering import Belief
from voa_core.grasps import best_grasp
from voa_core.scans import scan_of
from voa_core.updating import update_estimate
from voa_evaluation.looks.setting import default_imperfections
from voa_evaluation.looks.trials import Trial, TrialBench, make_trial
from voa_evaluation.statistics import Interval, bootstrap_mean
from voa_evaluation.values.bench import Bench, make_bench
from voa_evaluation.values.cases import HINTED
from voa_evaluation.values.promises import simulated_promise
from voa_evaluation.values.results import ALL, Confirmation
from voa_evaluation.values.setting import ROBOT_ERRORS, Setting
from voa_fleet.statistics import wilson
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject

RULE, ERROR = "beam", ROBOT_ERRORS[1]


@dataclass(frozen=True)
class DropResult:
    """Result of a drop.

    Attributes:
        promised: success that VOA promises with the chosen look.
        with_look, without_look, random_look: True if the object was lifted.
        accepted: True if the scan of the chosen look was accepted, or no look was chosen.
        score: Q[grasp, true pose] of the grasp that was attempted after the chosen look.
    """

    promised: float
    with_look: bool
    without_look: bool
    random_look: bool
    accepted: bool
    score: float


def imperfections() -> Imperfections:
    """Return the world's errors: an LDS-01 in a room, the object's spread, and the robot's error."""
    return replace(default_imperfections(), robot_xy_m=ERROR.xy_m, robot_yaw_rad=ERROR.yaw_rad)


def drop_results(target: FleetObject, setting: Setting) -> list[DropResult]:
    """Drop an object many times, look and grasp.

    Raises:
        UnstableSimulation: the simulation became unstable.
    """
    bench = make_bench(target, RULE, ERROR, 2, setting.seed)
    trials = TrialBench(target, setting.seed)
    world = imperfections()
    return [
        _result(bench, trials, make_trial(target, HINTED, index, world, setting.seed), world)
        for index in range(setting.drops)
    ]


def _result(bench: Bench, trials: TrialBench, trial: Trial, world: Imperfections) -> DropResult:
    belief = Belief.of(trial.belief)
    promise = simulated_promise(bench, belief)
    before = best_grasp(bench.scenario.table, belief.p)
    after, accepted = belief, True
    if promise.recommended:
        after, accepted = _after_look(bench, trials, trial, promise.best, world)
    at_random, _ = _after_look(bench, trials, trial, trial.random_look, world)
    with_look, score = _attempted(bench, trials, trial, after)
    return DropResult(
        promised=before.expected_score + (promise.best_net if promise.recommended else 0.0),
        with_look=with_look,
        without_look=_attempted(bench, trials, trial, belief)[0],
        random_look=_attempted(bench, trials, trial, at_random)[0],
        accepted=accepted,
        score=score,
    )


def _after_look(
    bench: Bench, trials: TrialBench, trial: Trial, index: int, world: Imperfections
) -> tuple[Belief, bool]:
    """Belief after a look from the place of that index, and True if its scan was accepted."""
    message = trials.scan(trial, trials.target.scenario.sensors[index], world)
    scan = scan_of(bench.scenario.lidar, message.ranges, message.no_return or ())
    evidence = bench.scenario.evidence(scan, bench.sensors[index], bench.model.std)
    update = update_estimate(Estimate.of(Belief.of(trial.belief)), evidence, bench.scenario.policy)
    return update.belief, update.accepted


def _attempted(bench: Bench, trials: TrialBench, trial: Trial, belief: Belief) -> tuple[bool, float]:
    """Attempt the best grasp: True if the object was lifted, and the grasp's measured score at the true pose."""
    table = bench.scenario.table
    choice = best_grasp(table, belief.p)
    if choice.index is None:
        return False, 0.0
    pose = bench.scenario.poses.names.index(trial.drop.pose)
    lifted = trials.attempt(trial, table.names[choice.index]) == "lifted"
    return lifted, float(table.scores[choice.index, pose])


def confirmations(drops: Sequence[tuple[str, Sequence[DropResult]]], seed: int) -> list[Confirmation]:
    """Make the rows of all objects together and of each; the drops are given by object."""
    rows = [_row(name, [own], seed) for name, own in drops]
    return [_row(ALL, [own for _, own in drops], seed), *rows] if len(rows) > 1 else rows


def _row(name: str, strata: Sequence[Sequence[DropResult]], seed: int) -> Confirmation:
    drops = [drop for stratum in strata for drop in stratum]
    count = len(drops)
    lifted = sum(drop.with_look for drop in drops)
    return Confirmation(
        object=name,
        drops=count,
        promised=sum(drop.promised for drop in drops) / count,
        with_look=lifted,
        without_look=sum(drop.without_look for drop in drops),
        random_look=sum(drop.random_look for drop in drops),
        success=Interval(lifted / count, *wilson(lifted, count), count),
        gain=_paired([[float(drop.with_look) - drop.without_look for drop in stratum] for stratum in strata], seed),
        over_random=_paired(
            [[float(drop.with_look) - drop.random_look for drop in stratum] for stratum in strata], seed
        ),
        refused=sum(not drop.accepted for drop in drops),
        measured_scores=sum(drop.score for drop in drops) / count,
    )


def _paired(strata: Sequence[Sequence[float]], seed: int) -> Interval:
    return bootstrap_mean([np.array(stratum, dtype=np.float64) for stratum in strata], seed)
