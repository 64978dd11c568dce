"""Run of an evaluation of values: all benches, then the drops in MuJoCo, then the tables."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
from functools import partial
from itertools import product
from multiprocessing import get_context
from typing import TypeVar

from voa_evaluation.values.benches import BenchResults, evaluate_bench
from voa_evaluation.values.cases import UNIFORM
from voa_evaluation.values.confirmation import DropResult, confirmations, drop_results
from voa_evaluation.values.results import Counts, Values
from voa_evaluation.values.setting import RobotError, Setting
from voa_evaluation.values.several_tables import driving_rows, next_look_rows, several_rows, two_robot_rows
from voa_evaluation.values.single_looks import SingleLooks
from voa_evaluation.values.single_tables import bin_rows, difference_rows, look_values, promise_rows, way_rows
from voa_fleet.world.objects import FleetObject

Item = TypeVar("Item")
R = TypeVar("R")
Bar = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]
"""Function that opens a progress bar with a text and the total number of units."""


def evaluate_values(targets: Sequence[FleetObject], setting: Setting, bar: Bar, processes: int = 1) -> Values:
    """Evaluate the value of looks at objects.

    Args:
        targets: the objects.
        setting: extent of the evaluation.
        bar: opens a progress bar for each part of the work.
        processes: number of processes; the results do not depend on it.

    Raises:
        FleetError: an object's lidar is not known.
        UnstableSimulation: the simulation became unstable.
    """
    work = list(product(targets, setting.rules, setting.robot_errors))
    with bar("looks over scans", len(work)) as advance:
        benches = list(_each(partial(_bench, setting=setting), work, processes, advance))
    with bar("drops in MuJoCo", len(targets) if setting.drops else 0) as advance:
        dropped = targets if setting.drops else ()
        drops = list(_each(partial(drop_results, setting=setting), dropped, processes, advance))
    return _values([target.name for target in targets], setting, benches, drops)


def _bench(item: tuple[FleetObject, str, RobotError], setting: Setting) -> BenchResults:
    return evaluate_bench(*item, setting)


def _each(
    function: Callable[[Item], R], items: Iterable[Item], processes: int, advance: Callable[[int], None]
) -> Iterator[R]:
    """Apply a function to each item, in order, on one process or several."""
    if processes == 1:
        for item in items:
            yield function(item)
            advance(1)
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for result in pool.map(function, items):
            yield result
            advance(1)


def _values(
    names: Sequence[str], setting: Setting, benches: Sequence[BenchResults], drops: Sequence[Sequence[DropResult]]
) -> Values:
    groups = [
        [bench for bench in benches if (bench.rule, bench.robot_error) == (rule, error.name)]
        for rule, error in product(setting.rules, setting.robot_errors)
    ]
    singles = [by_kind for group in groups for by_kind in _by_kind(group)]
    return Values(
        setting=setting,
        counts=Counts(
            objects=tuple(names),
            scans=sum(bench.scans for bench in benches),
            cases=len(names) * (1 + setting.beliefs),
            sessions=sum(len(steps) for bench in benches for steps in bench.sessions.values()),
            attempts=sum(len(own) for own in drops) * 3,
        ),
        looks=tuple(
            row for bench in benches for looks in bench.single if looks.kind == UNIFORM for row in look_values(looks)
        ),
        promises=tuple(row for looks in singles for row in promise_rows(looks, setting.seed)),
        bins=tuple(
            row
            for group in groups
            for row in bin_rows([looks for bench in group for looks in bench.single], setting.seed)
        ),
        ways=tuple(row for looks in singles for row in way_rows(looks)),
        differences=tuple(row for looks in singles for row in difference_rows(looks)),
        several=tuple(row for group in groups for row in several_rows(group, setting.seed)),
        next_looks=tuple(row for group in groups for row in next_look_rows(group, setting.seed)),
        repetitions=tuple(row for bench in benches for row in bench.repetitions),
        pairs=tuple(bench.pair for bench in benches if bench.pair is not None),
        driving=tuple(row for group in groups for row in driving_rows(group)),
        two_robots=tuple(row for group in groups for row in two_robot_rows(group)),
        confirmations=tuple(confirmations(list(zip(names, drops, strict=True)), setting.seed)) if drops else (),
    )


def _by_kind(group: Sequence[BenchResults]) -> list[list[SingleLooks]]:
    """Looks of one rule and robot error, by kind of belief."""
    return [list(kind) for kind in zip(*(bench.single for bench in group), strict=True)]
