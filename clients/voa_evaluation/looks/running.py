"""The run of an evaluation: every drop, every update rule, every look; a row for each drop and rule."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass

from voa_client import Client
from voa_evaluation.grasp_scores import GraspScores, score_grasps
from voa_evaluation.looks.choices import choices
from voa_evaluation.looks.requests import (
    EstimateBefore,
    RegisteredObject,
    estimate_after_look,
    estimate_before_look,
    register,
)
from voa_evaluation.looks.rows import EvaluatedLook, Row, Rows
from voa_evaluation.looks.setting import BELIEFS, EVALUATED_RULES, Setting
from voa_evaluation.looks.trials import Trial, TrialBench, make_trial
from voa_fleet.world.objects import FleetObject
from voa_msgs.sessions import UpdatedEstimate

Progress = Callable[[int], None]
"""Function that is called with the number of units that have just been completed."""
Bar = Callable[[str, int], AbstractContextManager[Progress]]
"""Function that opens a progress bar with a text and the total number of units."""


@dataclass(frozen=True, eq=False)
class Subject:
    """An object under evaluation.

    Attributes:
        target: the object.
        bench: takes its scans and attempts its grasps.
        scores: its grasp scores.
        registered: its scenarios in the service.
    """

    target: FleetObject
    bench: TrialBench
    scores: GraspScores
    registered: RegisteredObject


def set_up(client: Client, target: FleetObject, scores: GraspScores, setting: Setting) -> Subject:
    """Register an object with the service, and build its bench.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
    """
    return Subject(target, TrialBench(target, setting.seed), scores, register(client, target, scores, EVALUATED_RULES))


def measure_scores(target: FleetObject, setting: Setting, progress: Progress | None = None) -> GraspScores:
    """Measure the grasp scores of an object, from random numbers that no trial uses."""
    return score_grasps(
        target, setting.attempts, setting.imperfections, setting.seed, processes=setting.processes, progress=progress
    )


def run_trials(client: Client, subjects: Sequence[Subject], setting: Setting, bar: Bar) -> Rows:
    """Run every trial under every update rule, with a look from every sensor configuration.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
        UnstableSimulation: the simulation became unstable.
    """
    rows: list[Row] = []
    for subject in subjects:
        total = len(BELIEFS) * setting.drops
        with (
            bar(f"{subject.target.name}: looks and grasps", total) as advance,
            ThreadPoolExecutor(setting.threads) as pool,
        ):
            for kind in BELIEFS:
                for index in range(setting.drops):
                    trial = make_trial(subject.target, kind, index, setting.imperfections, setting.seed)
                    rows += _rows_of(client, subject, trial, setting, pool)
                    advance(1)
    return Rows(tuple(rows))


def _rows_of(
    client: Client, subject: Subject, trial: Trial, setting: Setting, pool: ThreadPoolExecutor
) -> Iterator[Row]:
    sensors = subject.target.scenario.sensors
    scans = [subject.bench.scan(trial, sensor, setting.imperfections) for sensor in sensors]
    scenarios = subject.registered.scenarios
    # Requests wait for the network and the service; the simulation stays in this thread.
    before = [pool.submit(estimate_before_look, client, scenario, trial.belief) for scenario in scenarios.values()]
    after = [
        pool.submit(estimate_after_look, client, scenario, trial.belief, sensor, scan)
        for scenario in scenarios.values()
        for sensor, scan in zip(sensors, scans, strict=True)
    ]
    for place, rule in enumerate(scenarios):
        estimates = [waiting.result() for waiting in after[place * len(sensors) : (place + 1) * len(sensors)]]
        yield _row(subject, trial, rule, before[place].result(), estimates, setting.policies)


def _row(
    subject: Subject,
    trial: Trial,
    rule: str,
    before: EstimateBefore,
    estimates: Sequence[UpdatedEstimate],
    policies: Sequence[str],
) -> Row:
    truth = subject.target.poses.index(trial.drop.pose)
    without = EvaluatedLook(
        sensor=None,
        voa=0.0,
        expected=before.score,
        reason="",
        truth=trial.belief[truth],
        grasp=before.grasp,
        result=attempted(subject, trial, before.grasp),
    )
    looks = tuple(
        EvaluatedLook(
            sensor=sensor.name,
            voa=voa,
            expected=estimate.expected_score,
            reason=estimate.update.reason or "",
            truth=estimate.belief[truth],
            grasp=estimate.best_grasp,
            result=attempted(subject, trial, estimate.best_grasp),
        )
        for sensor, voa, estimate in zip(subject.target.scenario.sensors, before.voa, estimates, strict=True)
    )
    chosen = choices(policies, subject.registered, rule, trial, before)
    return Row(trial.object, trial.kind, trial.drop.index, trial.drop.pose, rule, without, looks, chosen)


def attempted(subject: Subject, trial: Trial, grasp: str | None) -> str:
    """Attempt a grasp in a trial and return its result; "none" where there is no grasp."""
    return "none" if grasp is None else subject.bench.attempt(trial, grasp)
