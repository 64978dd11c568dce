"""Grasp scores by simulation: every grasp is attempted a number of times at every pose, with pose noise."""

from collections.abc import Callable
from pathlib import Path

from voa_fleet.world.cells import make_cells
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject
from voa_setup.scores.partial import FinishedCell, PartialTable, digest_of

ATTEMPTS = 15
XY_M = 0.005
YAW_RAD = 0.0523598775598298
"""3 degrees."""

Progress = Callable[[int, int], None]
"""Function that is called with the number of finished cells and the number of all cells."""


def simulated_scores(
    target: FleetObject,
    *,
    attempts: int = ATTEMPTS,
    xy_m: float = XY_M,
    yaw_rad: float = YAW_RAD,
    seed: int = 0,
    processes: int = 1,
    progress: Progress | None = None,
    resume: Path | None = None,
) -> list[list[int]]:
    """Count the successes of simulated attempts of each grasp at each pose, (grasps, poses).

    The counts depend on the object, `attempts`, the noise and `seed`; not on `processes`, nor on interruptions.

    Args:
        target: the object.
        attempts: per cell.
        xy_m: standard deviation of the object's position about its pose, in x and in y, metres.
        yaw_rad: standard deviation of its heading, radians.
        seed: of the noise.
        processes: number of processes; 1: this one alone.
        progress: called at the start and after each finished cell.
        resume: file of finished cells, which grows with them, and from which the simulation resumes; None: none.

    Raises:
        UnstableSimulation: the simulation became unstable.
        OSError: the file of finished cells cannot be written.
    """
    pairs = [(pose, grasp) for grasp in target.grasps for pose in target.poses]
    partial = None if resume is None else PartialTable(resume, digest_of(target, attempts, xy_m, yaw_rad, seed))
    earlier = [] if partial is None else partial.read()
    counts = {(cell.pose, cell.grasp): cell.successes for cell in earlier}

    def report() -> None:
        if progress is not None:
            progress(len(counts), len(pairs))

    report()
    noise = Imperfections(object_xy_m=xy_m, object_yaw_rad=yaw_rad)
    missing = [pair for pair in pairs if pair not in counts]
    for cell in make_cells(target, missing, attempts, noise, seed, processes):
        counts[cell.pose, cell.grasp] = cell.successes
        if partial is not None:
            partial.add(FinishedCell(pose=cell.pose, grasp=cell.grasp, successes=cell.successes))
        report()
    return [[counts[pose, grasp] for pose in target.poses] for grasp in target.grasps]
