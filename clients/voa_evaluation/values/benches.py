"""Work at one bench, from the first scan to the samples that the tables need; benches may run in several processes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from voa_evaluation.values.bench import make_bench
from voa_evaluation.values.cases import HINTED, UNIFORM, cases_of
from voa_evaluation.values.driving import Drive, drives
from voa_evaluation.values.promises import simulated_promise
from voa_evaluation.values.results import PairValue, Repetition
from voa_evaluation.values.setting import PLANNED_RULE, SESSION_RULES, RobotError, Setting
from voa_evaluation.values.several_looks import SessionBench, SessionStep, run_sessions
from voa_evaluation.values.single_looks import SingleLooks, evaluate_single_looks
from voa_evaluation.values.together import TwoLooks, best_pair, repetitions, two_robots
from voa_evaluation.values.truth import truth_of
from voa_fleet.world.objects import FleetObject


@dataclass(frozen=True, eq=False)
class BenchResults:
    """Results at one object, under one rule, with one robot error; what a rule does not evaluate is empty.

    Attributes:
        object, rule, robot_error: of the bench.
        single: looks of the cases, one entry for each kind of belief.
        sessions: steps of each session, by way.
        repetitions: scans from one place and from several.
        pair: the best pair; None: not evaluated.
        drives: by price per metre and way.
        two: looks of two robots, by way.
        scans: number of the world's scans that were weighed.
    """

    object: str
    rule: str
    robot_error: str
    single: tuple[SingleLooks, ...]
    sessions: Mapping[str, Sequence[Sequence[SessionStep]]]
    repetitions: tuple[Repetition, ...]
    pair: PairValue | None
    drives: Mapping[tuple[float, str], Drive]
    two: Mapping[str, TwoLooks]
    scans: int


def evaluate_bench(target: FleetObject, rule: str, error: RobotError, setting: Setting) -> BenchResults:
    """Evaluate an object under a rule for a robot error, to the extent of the setting.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    bench = make_bench(target, rule, error, setting.scans, setting.seed)
    cases = cases_of(target.name, len(target.poses), setting.beliefs, setting.seed)
    truths = [truth_of(bench, case.belief) for case in cases]
    promises = [simulated_promise(bench, case.belief) for case in cases]
    single = []
    for kind in (UNIFORM, HINTED):
        own = [index for index, case in enumerate(cases) if case.kind == kind]
        single.append(
            evaluate_single_looks(
                bench,
                [cases[index] for index in own],
                [truths[index] for index in own],
                [promises[index] for index in own],
                setting.seed,
            )
        )
    sessions = {}
    if rule in SESSION_RULES and setting.sessions:
        sessions = dict(run_sessions(SessionBench(bench, setting.sessions, setting.seed)))
    planned = rule == PLANNED_RULE
    hinted = slice(1, None)
    return BenchResults(
        object=target.name,
        rule=rule,
        robot_error=error.name,
        single=tuple(single),
        sessions=sessions,
        repetitions=tuple(repetitions(bench, promises[0])) if rule in SESSION_RULES else (),
        pair=best_pair(bench, promises[0]) if planned else None,
        drives=drives(bench, cases[hinted], truths[hinted], promises[hinted]) if planned else {},
        two=two_robots(bench, cases[hinted], promises[hinted], setting.scans, setting.seed) if planned else {},
        scans=len(target.poses) * len(bench.sensors) * setting.scans,
    )
