"""Grasp scores as in the paper: every grasp is attempted a number of times at every pose, with pose noise."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from typing import get_args

from voa_fleet.episodes.bench import make_bench
from voa_fleet.statistics import wilson
from voa_fleet.world.attempts import Attempt, Result, attempt_grasp, attempt_rng
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.kinematics import GraspPlan
from voa_fleet.world.object_poses import noisy_pose, scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_fleet.world.scene import World
from voa_msgs.scenarios import MeasuredScores, ScenarioRequest

RESULTS: tuple[Result, ...] = get_args(Result)

Progress = Callable[[int], None]
"""Function that is called with the number of attempts that have just been made."""


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
class GraspScores:
    """Measured grasp scores of an object.

    Attributes:
        object: name of the object.
        poses, grasps: names, in the order of the table.
        attempts: per cell.
        seed: of the noise.
        opening_m: of the gripper.
        imperfections: of the attempts; only the object's pose noise matters.
        cells: (poses, grasps).
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
        """Numbers of successes, (grasps, poses), as in a scenario."""
        return [[row[grasp].successes for row in self.cells] for grasp in range(len(self.grasps))]

    def scenario(self, base: ScenarioRequest) -> ScenarioRequest:
        """Return the scenario with these scores instead of its own.

        Raises:
            ValueError: the scenario has other poses or grasps.
        """
        known = tuple(pose.name for pose in base.poses), tuple(grasp.name for grasp in base.grasps)
        if known != (self.poses, self.grasps):
            raise ValueError(f"expected scores of {known}, got {(self.poses, self.grasps)}")
        measured = MeasuredScores(attempts=self.attempts, successes=self.successes)
        changed = base.model_dump(mode="json") | {"scores": measured.model_dump(mode="json")}
        return ScenarioRequest.model_validate(changed)


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

    The scores depend on the object, `attempts`, `imperfections` and `seed`; not on `processes`, on the selection of
    poses and grasps, or on their order.

    Args:
        target: the object.
        attempts: per cell.
        imperfections: of which the object's pose noise is used.
        seed: of the noise.
        processes: number of processes; 1: this one alone.
        poses, grasps: names; None: all of the scenario's.
        progress: called after every cell with its number of attempts.

    Raises:
        UnstableSimulation: the simulation became unstable.
    """
    rows, columns = tuple(poses or target.poses), tuple(grasps or target.grasps)
    bench = make_bench(target, imperfections, seed)
    plans = {grasp: bench.arm.plan(grasp) for grasp in columns}
    tasks = [
        _Task(target, pose, grasp, plans[grasp], attempts, imperfections, seed) for pose in rows for grasp in columns
    ]
    by_name: dict[tuple[str, str], Cell] = {}
    for cell in (
        _in_processes(tasks, processes) if processes > 1 else (_cell(task, bench.scene.world) for task in tasks)
    ):
        by_name[cell.pose, cell.grasp] = cell
        if progress is not None:
            progress(cell.attempts)
    cells = tuple(tuple(by_name[pose, grasp] for grasp in columns) for pose in rows)
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
    return attempt_grasp(world, task.plan, noisy_pose(scenario_pose(task.target, task.pose), task.imperfections, rng))


def _cell_elsewhere(task: _Task) -> Cell:
    return _cell(task, make_bench(task.target, task.imperfections, task.seed).scene.world)


def _in_processes(tasks: list[_Task], processes: int) -> Iterator[Cell]:
    # Spawned, because a fork of a process with threads may hang, and MuJoCo may have threads.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        waiting = [pool.submit(_cell_elsewhere, task) for task in tasks]
        for done in as_completed(waiting):
            yield done.result()
