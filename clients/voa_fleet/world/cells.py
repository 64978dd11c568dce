"""Cells of a table of grasp scores: attempts of one grasp at one pose, with pose noise.

A cell depends on object, pose, grasp, noise and seed alone: neither on the other cells nor on the number of processes.
"""

import signal
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from typing import get_args

from voa_fleet.statistics import wilson
from voa_fleet.world.attempts import Attempt, Result, attempt_grasp, attempt_rng
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.object_poses import noisy_pose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World, build_world

RESULTS: tuple[Result, ...] = get_args(Result)
_BATCHES = 8
"""Batches of cells per process, from which processes that are done early take more."""
_MOST = 8
"""Largest number of cells in a batch: all of them are reported together."""


@dataclass(frozen=True)
class Cell:
    """Attempts of a grasp at a pose.

    Attributes:
        pose, grasp: their names.
        results: number of attempts by their result.
    """

    pose: str
    grasp: str
    results: dict[Result, int]

    @property
    def attempts(self) -> int:
        """Number of attempts."""
        return sum(self.results.values())

    @property
    def successes(self) -> int:
        """Number of attempts that lifted the object."""
        return self.results.get("lifted", 0)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability of success."""
        return wilson(self.successes, self.attempts)


@dataclass(frozen=True)
class _Batch:
    """Cells that a process makes one after the other, in one world."""

    target: FleetObject
    cells: list[tuple[str, str, GraspPlan | None]]
    attempts: int
    imperfections: Imperfections
    seed: int


def make_cells(
    target: FleetObject,
    pairs: Sequence[tuple[str, str]],
    attempts: int,
    imperfections: Imperfections,
    seed: int,
    processes: int = 1,
) -> Iterator[Cell]:
    """Attempt grasps at poses, and yield each cell when it is finished, in any order.

    Args:
        target: the object.
        pairs: names of a pose and a grasp.
        attempts: per cell.
        imperfections: of which the object's pose noise is used.
        seed: of the noise.
        processes: number of processes; 1: this one alone.

    Raises:
        UnknownName: there is no such pose or grasp.
        UnstableSimulation: the simulation became unstable.
    """
    if not pairs:
        return
    world = build_world(target)
    plans = {grasp: plan_grasp(world, target.grasp(grasp)) for grasp in dict.fromkeys(grasp for _, grasp in pairs)}
    cells = [(pose, grasp, plans[grasp]) for pose, grasp in pairs]
    if processes == 1:
        yield from _made(_Batch(target, cells, attempts, imperfections, seed), world)
        return
    size = max(1, min(_MOST, len(cells) // (processes * _BATCHES)))
    batches = [
        _Batch(target, cells[start : start + size], attempts, imperfections, seed)
        for start in range(0, len(cells), size)
    ]
    # Spawned, because a fork of a process with threads may hang, and MuJoCo may have threads.
    # Ctrl-C reaches every process; the others end at once, without a traceback each.
    ending = (signal.SIGINT, signal.SIG_DFL)
    with ProcessPoolExecutor(processes, get_context("spawn"), signal.signal, ending) as pool:
        waiting = [pool.submit(_made_elsewhere, batch) for batch in batches]
        try:
            for done in as_completed(waiting):
                yield from done.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _made_elsewhere(batch: _Batch) -> list[Cell]:
    """Make a batch's cells in a process that has no world yet."""
    return list(_made(batch, build_world(batch.target)))


def _made(batch: _Batch, world: World) -> Iterator[Cell]:
    for pose, grasp, plan in batch.cells:
        results = Counter(_attempted(batch, world, pose, grasp, plan, index).result for index in range(batch.attempts))
        yield Cell(pose, grasp, {result: results[result] for result in RESULTS if results[result]})


def _attempted(batch: _Batch, world: World, pose: str, grasp: str, plan: GraspPlan | None, index: int) -> Attempt:
    rng = attempt_rng(batch.seed, pose, grasp, index)
    return attempt_grasp(world, plan, noisy_pose(scenario_pose(batch.target, pose), batch.imperfections, rng))
