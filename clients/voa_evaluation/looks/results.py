"""Results of an evaluation of looks: its rows, and the figures that follow from them."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client import Client
from voa_core.rules.inverse_rmsd import InverseRmsd
from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.looks.calibration import Bin, calibration
from voa_evaluation.looks.outcomes import Level, Outcome, levels, outcomes
from voa_evaluation.looks.requests import estimate_after_look
from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.running import Bar, Subject, measure_scores, run_trials, set_up
from voa_evaluation.looks.sensitivity import Point, vary
from voa_evaluation.looks.setting import Setting
from voa_evaluation.looks.trials import make_trial
from voa_evaluation.looks.worth import Gain, Worth, gains, worths
from voa_fleet.episodes.policies import policy_named
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import Scenario

_EXAMPLE_RULE = InverseRmsd.name


@dataclass(frozen=True, eq=False)
class Example:
    """A look in full: the beliefs before and after it.

    Attributes:
        scenario: in the service.
        pose: name of the true pose.
        sensor: name of the sensor configuration.
        before, after: beliefs, (poses,).
    """

    scenario: Scenario
    pose: str
    sensor: str
    before: list[float]
    after: list[float]


@dataclass(frozen=True, eq=False)
class Results:
    """Results of an evaluation; all figures are computed from `rows` and `points`.

    Attributes:
        setting: extent of the evaluation.
        scores: measured grasp scores, per object.
        examples: a look per object.
        rows: of all trials.
        points: of all curves of sensitivity.
        attempts: number of pairs of drop and grasp that were simulated.
        worths: per object, kind of belief, rule and sensor configuration.
        gains: per object, kind of belief and rule.
        outcomes: per policy.
        bins: of the calibration.
        levels: of the disturbances.
    """

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


def evaluate_looks(client: Client, targets: Sequence[FleetObject], setting: Setting, bar: Bar) -> Results:
    """Run the whole evaluation of looks.

    Args:
        client: of the service.
        targets: the objects.
        setting: extent of the evaluation.
        bar: opens a progress bar for each part of the work.

    Raises:
        UnknownName: the setting names a policy that does not exist.
        VoaClientError: the service refuses a request, or does not answer.
        UnstableSimulation: the simulation became unstable.
    """
    for name in setting.policies:  # before hours of work
        policy_named(name)
    subjects = []
    for target in targets:
        total = setting.attempts * len(target.poses) * len(target.grasps)
        with bar(f"{target.name}: grasp scores", total) as advance:
            scores = measure_scores(target, setting, advance)
        subjects.append(set_up(client, target, scores, setting))
    rows = run_trials(client, subjects, setting, bar)
    points = vary(client, subjects, setting, bar)
    return Results(
        setting=setting,
        scores=tuple(subject.scores for subject in subjects),
        examples=tuple(_example(client, subject, rows, setting) for subject in subjects),
        rows=rows,
        points=points,
        attempts=sum(subject.bench.attempts for subject in subjects),
        worths=worths(rows, setting.seed),
        gains=gains(rows, setting.seed),
        outcomes=outcomes(rows, setting.seed),
        bins=calibration(rows, setting.seed),
        levels=levels(points, setting.seed),
    )


def _example(client: Client, subject: Subject, rows: Rows, setting: Setting) -> Example:
    """The look that VOA chose at the first drop with a uniform belief; from the first place where it chose none."""
    row = rows.of(name=subject.target.name, kind="uniform", rule=_EXAMPLE_RULE).rows[0]
    name = row.chosen["voa"] or row.looks[0].sensor or ""
    sensor = next(sensor for sensor in subject.target.scenario.sensors if sensor.name == name)
    trial = make_trial(subject.target, "uniform", row.drop, setting.imperfections, setting.seed)
    scenario = subject.registered.scenarios[_EXAMPLE_RULE]
    scan = subject.bench.scan(trial, sensor, setting.imperfections)
    after = estimate_after_look(client, scenario, trial.belief, sensor, scan)
    return Example(scenario, trial.drop.pose, name, list(trial.belief), after.belief)
