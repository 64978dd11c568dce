"""Grasp scores as the paper takes them: every grasp at every pose, attempted a number of times with pose noise."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from math import sqrt
from multiprocessing import get_context
from typing import Any, get_args

from voa_fleet.world.attempts import Attempt, Result, attempt_grasp, attempt_rng, noisy_pose, object_pose
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import GraspPlan, plan_grasp
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World, build_world
from voa_msgs.scenarios import MeasuredScores, ScenarioRequest

RESULTS: tuple[Result, ...] = get_args(Result)

Progress = Callable[[int], None]
"""Told how many attempts have just been made."""


@dataclass(frozen=True)
class Cell:
    """All attempts of one grasp at one pose.

    Attributes:
        results: how many attempts ended in which way; sums to the number of attempts.
    """

    pose: str
    grasp: str
    results: dict[Result, int]

    @property
    def attempts(self) -> int:
        """n of k of n."""
        return sum(self.results.values())

    @property
    def successes(self) -> int:
        """k of k of n."""
        return self.results.get("lifted", 0)

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability of success."""
        return wilson(self.successes, self.attempts)


@dataclass(frozen=True)
class GraspScores:
    """The table of an object.

    Attributes:
        poses, grasps: names, in the order of the table.
        attempts: per cell.
        imperfections: with which they were made; only the object's pose noise matters.
        cells: poses x grasps.
    """

    object: str
    poses: tuple[str, ...]
    grasps: tuple[str, ...]
    attempts: int
    seed: int
    opening_m: float
    imperfections: Imperfections
    cells: tuple[tuple[Cell, ...], ...]

    @property
    def successes(self) -> list[list[int]]:
        """Grasps x poses, as scenarios have them."""
        return [[row[grasp].successes for row in self.cells] for grasp in range(len(self.grasps))]

    def scenario(self, base: ScenarioRequest) -> ScenarioRequest:
        """The scenario with these scores in place of its own.

        Raises:
            ValueError: the scenario has other poses or grasps than the table.
        """
        known = tuple(pose.name for pose in base.poses), tuple(grasp.name for grasp in base.grasps)
        if known != (self.poses, self.grasps):
            raise ValueError(f"expected scores of {known}, got {(self.poses, self.grasps)}")
        measured = MeasuredScores(attempts=self.attempts, successes=self.successes)
        told = base.model_dump(mode="json") | {"scores": measured.model_dump(mode="json")}
        return ScenarioRequest.model_validate(told)

    def report(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "object": self.object,
            "attempts": self.attempts,
            "seed": self.seed,
            "opening_m": self.opening_m,
            "noise": {key: asdict(self.imperfections)[key] for key in ("object_xy_m", "object_yaw_rad")},
            "poses": list(self.poses),
            "grasps": list(self.grasps),
            "successes": self.successes,
            "cells": [
                {
                    "pose": cell.pose,
                    "grasp": cell.grasp,
                    "successes": cell.successes,
                    "attempts": cell.attempts,
                    "interval": list(cell.interval),
                    "results": dict(cell.results),
                }
                for row in self.cells
                for cell in row
            ],
        }


def score_grasps(
    target: FleetObject,
    attempts: int,
    imperfections: Imperfections,
    seed: int,
    *,
    processes: int = 1,
    poses: Sequence[str] | None = None,
    grasps: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> GraspScores:
    """Attempt every grasp at every pose.

    The table depends on the object, `attempts`, `imperfections` and `seed`; not on `processes`, nor on which poses and
    grasps are asked for, nor on their order.

    Args:
        target: the object.
        attempts: per cell.
        imperfections: the object's pose noise counts.
        seed: of the noise.
        processes: how many work at a time; 1: this one alone.
        poses, grasps: names; None: all of the scenario's.
        progress: told after every cell.
    """
    rows, columns = tuple(poses or target.poses), tuple(grasps or target.grasps)
    world = build_world(target)
    plans = {grasp: plan_grasp(world, target.grasp(grasp)) for grasp in columns}
    wanted = [_Task(target, pose, grasp, plans[grasp], attempts, imperfections, seed) for pose in rows for grasp in columns]
    found: dict[tuple[str, str], Cell] = {}
    for cell in _in_processes(wanted, processes) if processes > 1 else (_cell(task, world) for task in wanted):
        found[cell.pose, cell.grasp] = cell
        if progress is not None:
            progress(cell.attempts)
    cells = tuple(tuple(found[pose, grasp] for grasp in columns) for pose in rows)
    opening = target.physics.gripper.opening_m
    return GraspScores(target.name, rows, columns, attempts, seed, opening, imperfections, cells)


@dataclass(frozen=True)
class _Task:
    target: FleetObject
    pose: str
    grasp: str
    plan: GraspPlan | None
    attempts: int
    imperfections: Imperfections
    seed: int


def _cell(task: _Task, world: World) -> Cell:
    results = Counter(_one(task, world, index).result for index in range(task.attempts))
    return Cell(task.pose, task.grasp, {result: results[result] for result in RESULTS if results[result]})


def _one(task: _Task, world: World, index: int) -> Attempt:
    rng = attempt_rng(task.seed, task.pose, task.grasp, index)
    return attempt_grasp(world, task.plan, noisy_pose(object_pose(task.target, task.pose), task.imperfections, rng))


def _cell_elsewhere(task: _Task) -> Cell:
    return _cell(task, build_world(task.target))


def _in_processes(tasks: list[_Task], processes: int) -> Iterator[Cell]:
    # Spawned: a fork of a process with threads may hang, and MuJoCo may have some.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(_cell_elsewhere, task) for task in tasks]
        for done in as_completed(waiting):
            yield done.result()


def wilson(successes: int, attempts: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson's interval of a probability from k successes of n attempts (E. B. Wilson, JASA 22, 1927)."""
    if attempts == 0:
        return 0.0, 1.0
    share, extra = successes / attempts, z * z / attempts
    middle = (share + extra / 2.0) / (1.0 + extra)
    half = z * sqrt(share * (1.0 - share) / attempts + extra / (4.0 * attempts)) / (1.0 + extra)
    return max(0.0, middle - half), min(1.0, middle + half)
