"""Grasp scores as in the paper: every grasp is attempted a number of times at every pose, with pose noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from voa_fleet.world.cells import Cell, make_cells
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import MeasuredScores, ScenarioRequest

Progress = Callable[[int], None]
"""Function that is called with the number of attempts that have just been made."""


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
    pairs = [(pose, grasp) for pose in rows for grasp in columns]
    by_name: dict[tuple[str, str], Cell] = {}
    for cell in make_cells(target, pairs, attempts, imperfections, seed, processes):
        by_name[cell.pose, cell.grasp] = cell
        if progress is not None:
            progress(cell.attempts)
    cells = tuple(tuple(by_name[pose, grasp] for grasp in columns) for pose in rows)
    opening = target.physics.gripper.opening_m
    return GraspScores(target.name, rows, columns, attempts, seed, opening, imperfections, cells)
