"""All that the evaluation of looks found, and the figures that follow from it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from voa_client import Client
from voa_evaluation.looks.requests import after_a_look
from voa_evaluation.looks.calibration import Bin, calibration
from voa_evaluation.looks.trials import make_drop
from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.looks.outcomes import Level, Outcome, levels, outcomes
from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.running import Bar, Subject, evaluate, scores_of, set_up
from voa_evaluation.looks.sensitivity import Point, vary
from voa_evaluation.looks.setting import Setting
from voa_evaluation.looks.worth import Gain, Worth, gains, worths
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import Scenario

_SHOWN_RULE = "inverse_rmsd"


@dataclass(frozen=True, eq=False)
class Example:
    """One look in full: the belief before and after it.

    Attributes:
        pose: the true one.
        sensor: from where the look was.
        before, after: beliefs.
    """

    scenario: Scenario
    pose: str
    sensor: str
    before: list[float]
    after: list[float]


@dataclass(frozen=True, eq=False)
class Found:
    """What was found; figures are made from `rows` and `points` alone."""

    setting: Setting
    scores: tuple[GraspScores, ...]
    examples: tuple[Example, ...]
    rows: Rows
    points: tuple[Point, ...]
    attempts: int
    worths: list[Worth]
    gains: list[Gain]
    outcomes: list[Outcome]
    bins: list[Bin]
    levels: list[Level]

    def report(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "drops": self.setting.drops,
            "attempts_per_score": self.setting.attempts,
            "sensitivity_drops": self.setting.sensitivity_drops,
            "seed": self.setting.seed,
            "attempts": self.attempts,
            "looks": [asdict(worth) for worth in self.worths],
            "gains": [asdict(gain) for gain in self.gains],
            "policies": [asdict(outcome) for outcome in self.outcomes],
            "calibration": [asdict(found) for found in self.bins],
            "sensitivity": [asdict(level) for level in self.levels],
        }


def find(client: Client, targets: Sequence[FleetObject], setting: Setting, bar: Bar) -> Found:
    """Run the whole evaluation of looks.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
        UnstableSimulation: the physics exploded.
    """
    subjects = []
    for target in targets:
        total = setting.attempts * len(target.poses) * len(target.grasps)
        with bar(f"{target.name}: grasp scores", total) as advance:
            scores = scores_of(target, setting, advance)
        subjects.append(set_up(client, target, scores, setting))
    rows = evaluate(client, subjects, setting, bar)
    points = vary(client, subjects, setting, bar)
    return Found(
        setting=setting,
        scores=tuple(subject.scores for subject in subjects),
        examples=tuple(_example(client, subject, rows, setting) for subject in subjects),
        rows=rows,
        points=points,
        attempts=sum(subject.table.attempts for subject in subjects),
        worths=worths(rows, setting.seed),
        gains=gains(rows, setting.seed),
        outcomes=outcomes(rows, setting.seed),
        bins=calibration(rows, setting.seed),
        levels=levels(points, setting.seed),
    )


def _example(client: Client, subject: Subject, rows: Rows, setting: Setting) -> Example:
    """The look that VOA chose at the first drop with a uniform belief; the first place where it chose none."""
    row = rows.of(target=subject.target.name, kind="uniform", rule=_SHOWN_RULE).rows[0]
    name = row.chosen["voa"] or row.looks[0].sensor or ""
    sensor = next(sensor for sensor in subject.target.scenario.sensors if sensor.name == name)
    drop = make_drop(subject.target, "uniform", row.drop, setting.imperfections, setting.seed)
    scenario = subject.asked.scenarios[_SHOWN_RULE]
    scan = subject.table.scan(drop, sensor, setting.imperfections)
    after = after_a_look(client, scenario, drop.belief, sensor, scan)
    return Example(scenario, drop.pose, name, list(drop.belief), after.belief)
