"""The run: every drop, every rule, every look; one row each."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass

from voa_client import Client
from voa_evaluation.looks.requests import Asked, Beforehand, after_a_look, ask, before_any_look
from voa_evaluation.looks.trials import Drop, Table, make_drop
from voa_evaluation.grasp_scores import GraspScores, score_grasps
from voa_evaluation.looks.choices import choices
from voa_evaluation.looks.rows import Look, Row, Rows
from voa_evaluation.looks.setting import BELIEFS, RULES, Setting
from voa_fleet.world.objects import FleetObject
from voa_msgs.sessions import UpdatedEstimate

Progress = Callable[[int], None]
Bar = Callable[[str, int], AbstractContextManager[Progress]]
"""Opens a progress bar: what is done, how many there are."""


@dataclass(frozen=True, eq=False)
class Subject:
    """One object, ready to be evaluated: its table, its scores, and what the service knows of it."""

    target: FleetObject
    table: Table
    scores: GraspScores
    asked: Asked


def set_up(client: Client, target: FleetObject, scores: GraspScores, setting: Setting) -> Subject:
    """Tell the service of the object."""
    return Subject(target, Table(target, setting.seed), scores, ask(client, target, scores, RULES))


def scores_of(target: FleetObject, setting: Setting, progress: Progress | None = None) -> GraspScores:
    """Grasp scores as this fleet measures them, with noise that no drop shares."""
    return score_grasps(
        target, setting.attempts, setting.imperfections, setting.seed, processes=setting.processes, progress=progress
    )


def evaluate(client: Client, subjects: Sequence[Subject], setting: Setting, bar: Bar) -> Rows:
    """Every drop under every rule, looked at from everywhere.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
        UnstableSimulation: the physics exploded.
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
                    drop = make_drop(subject.target, kind, index, setting.imperfections, setting.seed)
                    rows += _rows_of(client, subject, drop, setting, pool)
                    advance(1)
    return Rows(tuple(rows))


def _rows_of(client: Client, subject: Subject, drop: Drop, setting: Setting, pool: ThreadPoolExecutor) -> Iterator[Row]:
    sensors = subject.target.scenario.sensors
    scans = [subject.table.scan(drop, sensor, setting.imperfections) for sensor in sensors]
    scenarios = subject.asked.scenarios
    # Requests wait for the network and the service; the physics stays in this thread.
    before = [pool.submit(before_any_look, client, scenario, drop.belief) for scenario in scenarios.values()]
    after = [
        pool.submit(after_a_look, client, scenario, drop.belief, sensor, scan)
        for scenario in scenarios.values()
        for sensor, scan in zip(sensors, scans, strict=True)
    ]
    for place, rule in enumerate(scenarios):
        told = before[place].result()
        answers = [waiting.result() for waiting in after[place * len(sensors) : (place + 1) * len(sensors)]]
        yield _row(subject, drop, rule, told, answers)


def _row(subject: Subject, drop: Drop, rule: str, told: Beforehand, answers: Sequence[UpdatedEstimate]) -> Row:
    truth = subject.target.poses.index(drop.pose)
    before = Look(None, 0.0, told.score, "", drop.belief[truth], told.grasp, attempted(subject, drop, told.grasp))
    looks = tuple(
        Look(
            sensor=sensor.name,
            voa=voa,
            expected=answer.expected_score,
            reason=answer.update.reason or "",
            truth=answer.belief[truth],
            grasp=answer.best_grasp,
            result=attempted(subject, drop, answer.best_grasp),
        )
        for sensor, voa, answer in zip(subject.target.scenario.sensors, told.voa, answers, strict=True)
    )
    return Row(
        drop.object, drop.kind, drop.index, drop.pose, rule, before, looks, choices(subject.asked, rule, drop, told)
    )


def attempted(subject: Subject, drop: Drop, grasp: str | None) -> str:
    """What comes of a grasp; "none" of none."""
    return "none" if grasp is None else subject.table.attempt(drop, grasp)
