"""Tables of several looks, of driving, and of two robots, from the results at all benches."""

from collections.abc import Sequence

import numpy as np

from voa_evaluation.statistics import bootstrap_mean
from voa_evaluation.values.benches import BenchResults
from voa_evaluation.values.policies import VOA
from voa_evaluation.values.results import ALL, DrivingValue, NextLookValue, SeveralLooks, TwoRobots
from voa_evaluation.values.samples import interval_of
from voa_evaluation.values.several_looks import LOOKS, SESSION_WAYS, SessionStep
from voa_evaluation.values.together import ANNOUNCED


def _groups(results: Sequence[BenchResults]) -> list[tuple[str, list[BenchResults]]]:
    """Group results of one rule and robot error: all objects, where there are several, and each alone."""
    alone = [(each.object, [each]) for each in results]
    return [(ALL, list(results)), *alone] if len(results) > 1 else alone


def several_rows(results: Sequence[BenchResults], seed: int) -> list[SeveralLooks]:
    """Make the rows of the sessions of one rule and robot error; empty where it has none."""
    with_sessions = [each for each in results if each.sessions]
    return [
        _several(name, own, way, looks, seed)
        for name, own in (_groups(with_sessions) if with_sessions else [])
        for way in SESSION_WAYS
        for looks in range(LOOKS + 1)
    ]


def _several(name: str, results: Sequence[BenchResults], way: str, looks: int, seed: int) -> SeveralLooks:
    strata: list[list[SessionStep]] = [[session[looks] for session in each.sessions[way]] for each in results]
    achieved = [np.array([step.achieved for step in stratum]) for stratum in strata]
    return SeveralLooks(
        object=name,
        rule=results[0].rule,
        robot_error=results[0].robot_error,
        way=way,
        looks=looks,
        taken=float(np.mean([step.taken for stratum in strata for step in stratum])),
        promised=float(np.mean([np.mean([step.promised for step in stratum]) for stratum in strata])),
        achieved=bootstrap_mean(achieved, seed),
        repeated=sum(step.repeated for stratum in strata for step in stratum),
    )


def next_look_rows(results: Sequence[BenchResults], seed: int) -> list[NextLookValue]:
    """Compare promised with achieved gains of the looks in sessions of `voa`, of one rule and robot error."""
    sessions = [session for each in results if each.sessions for session in each.sessions[VOA]]
    rows = []
    for look in range(1, LOOKS + 1):
        for place, again in (("new", False), ("repeated", True)):
            taken = [
                (session[look - 1], session[look])
                for session in sessions
                if session[look].gain is not None and session[look].again == again
            ]
            if taken:
                promised = [after.gain for _, after in taken if after.gain is not None]
                achieved = np.array([after.achieved - before.achieved for before, after in taken])
                interval = bootstrap_mean([achieved], seed)
                first = results[0]
                rows.append(
                    NextLookValue(first.rule, first.robot_error, look, place, float(np.mean(promised)), interval)
                )
    return rows


def driving_rows(results: Sequence[BenchResults]) -> list[DrivingValue]:
    """Make the rows of driving of one rule and robot error, over all objects; empty where it has none."""
    own = [each.drives for each in results if each.drives]
    rows = []
    for cost, way in own[0] if own else ():
        each_object = [drives[cost, way] for drives in own]
        promised = [drive.promised for drive in each_object if drive.promised is not None]
        rows.append(
            DrivingValue(
                robot_error=results[0].robot_error,
                cost_per_m=cost,
                way=way,
                net=interval_of([drive.net for drive in each_object]),
                metres=float(np.mean([drive.metres for drive in each_object])),
                grasped=sum(drive.grasped for drive in each_object),
                promised=float(np.mean(promised)) if promised else None,
            )
        )
    return rows


def two_robot_rows(results: Sequence[BenchResults]) -> list[TwoRobots]:
    """Make the rows of two robots of one rule and robot error; empty where it has none."""
    with_two = [each for each in results if each.two]
    return [_two(name, own, way) for name, own in (_groups(with_two) if with_two else []) for way in with_two[0].two]


def _two(name: str, results: Sequence[BenchResults], way: str) -> TwoRobots:
    own = [each.two[way] for each in results]
    apart = [each.two[ANNOUNCED].gains - each.two[way].gains for each in results]
    return TwoRobots(
        object=name,
        robot_error=results[0].robot_error,
        aware=way,
        promised=float(np.mean([looks.promised for looks in own])),
        achieved=interval_of([looks.gains for looks in own]),
        same_place=sum(looks.same_place for looks in own),
        difference=None if way == ANNOUNCED else interval_of(apart),
    )
