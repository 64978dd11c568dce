"""Grasp scores of a new scenario: from simulated attempts, from the shapes alone, or from a table that a lab filled."""

import shutil
from collections.abc import Sequence
from itertools import compress
from pathlib import Path
from typing import Protocol

from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import read_object
from voa_msgs.scenarios import GivenScores, MeasuredScores, Pose, ScenarioRequest, Scores
from voa_setup.choices import GEOMETRIC, SIMULATED, Choices
from voa_setup.grasps.proposals import ProposedGrasp
from voa_setup.grasps.scoring import geometric_scores
from voa_setup.scores.simulation import simulated_scores
from voa_setup.scores.table import read_scores, write_empty_scores, write_scores
from voa_setup.writing import PARTIAL, write_scenario

TABLE = "scores.csv"
"""File with the successes and attempts of each grasp at each pose."""
_DIGITS = 4


class Stages(Protocol):
    """Display of the steps for a person."""

    def begin(self, text: str) -> None:
        """Show that a step begins."""

    def advance(self, done: int, total: int) -> None:
        """Show how many parts of the current step are finished."""


def first_scores(choices: Choices, mesh: Mesh, poses: Sequence[Pose], grasps: Sequence[ProposedGrasp]) -> Scores:
    """Read the scores from the table of a lab, or guess them from the shapes alone, (grasps, poses).

    Raises:
        InvalidScores: the table cannot be read, or does not fit the grasps and poses.
    """
    if choices.scores not in (SIMULATED, GEOMETRIC):
        return read_scores(Path(choices.scores), [grasp.name for grasp in grasps], [pose.name for pose in poses])
    geometries = [grasp.geometry for grasp in grasps]
    scores = geometric_scores(
        mesh, poses, geometries, choices.gripper, xy_m=choices.xy_m, yaw_rad=choices.yaw_rad, seed=choices.seed
    )
    return GivenScores(probabilities=[[round(score, _DIGITS) for score in row] for row in scores])


def without_failures(scenario: ScenarioRequest) -> tuple[ScenarioRequest, list[str]]:
    """Leave out the grasps that succeed at no pose, and name them in a sentence; if all fail, none is left out."""
    table = scenario.scores
    if isinstance(table, MeasuredScores):
        succeeding = [any(row) for row in table.successes]
    else:
        succeeding = [any(row) for row in table.probabilities]
    if all(succeeding) or not any(succeeding):
        return scenario, []
    scores: Scores
    if isinstance(table, MeasuredScores):
        scores = MeasuredScores(attempts=table.attempts, successes=list(compress(table.successes, succeeding)))
    else:
        scores = GivenScores(probabilities=list(compress(table.probabilities, succeeding)))
    failing = [grasp.name for grasp, succeeds in zip(scenario.grasps, succeeding, strict=True) if not succeeds]
    changes = {"scores": scores, "grasps": list(compress(scenario.grasps, succeeding))}
    note = f"Left out because they succeed at no pose: {', '.join(failing)}."
    return scenario.model_copy(update=changes), [note]


def final_scores(choices: Choices, draft: ScenarioRequest, folder: Path, stages: Stages) -> tuple[Scores, str]:
    """Return the scores from the source that was chosen, and a note about them; writes `scores.csv` beside them.

    Args:
        choices: with the source.
        draft: the scenario with its first scores.
        folder: with the mesh and the physical properties; the draft is written for simulated attempts.
        stages: receives the progress of simulated attempts.

    Raises:
        FleetError: the simulation refuses the object.
    """
    poses, grasps = [pose.name for pose in draft.poses], [grasp.name for grasp in draft.grasps]
    table = folder / TABLE
    if choices.scores == GEOMETRIC:
        if not table.exists():  # one that a lab has filled stays
            write_empty_scores(table, grasps, poses)
        return draft.scores, (
            "The grasp scores are a first guess from the shapes alone, without weight, slip and pushes: replace them "
            "by simulated ones (--scores simulated) or measured ones (--scores FILE.csv) before a robot relies on them."
        )
    if choices.scores != SIMULATED:
        source = Path(choices.scores)
        if source.resolve() != table.resolve():
            shutil.copyfile(source, table)
        return draft.scores, f"The grasp scores are those of {choices.scores}."
    write_scenario(draft, folder)
    successes = simulated_scores(
        read_object(folder),
        attempts=choices.attempts,
        xy_m=choices.xy_m,
        yaw_rad=choices.yaw_rad,
        seed=choices.seed,
        processes=choices.processes,
        progress=stages.advance,
        resume=folder / PARTIAL,
    )
    scores = MeasuredScores(attempts=choices.attempts, successes=successes)
    write_scores(table, grasps, poses, scores)
    return scores, (
        f"The grasp scores count the successes of {choices.attempts} simulated attempts each, with the object "
        f"{1e3 * choices.xy_m:g} mm and {choices.yaw_deg:g} degrees off its pose (standard deviations)."
    )
