"""Sensitivity of looks to imperfections of the world: success against one disturbance at a time.

The look is the one that VOA recommends, whatever the disturbance. Trials, scans and attempts share their random
numbers between levels.
"""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from voa_client import Client
from voa_evaluation.looks.requests import EstimateBefore, estimate_after_look, estimate_before_look
from voa_evaluation.looks.running import Bar, Subject, attempted
from voa_evaluation.looks.setting import Setting
from voa_evaluation.looks.trials import Trial, boxes, make_trial
from voa_fleet.world.imperfections import Imperfections
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.sessions import Scan


@dataclass(frozen=True)
class Disturbance:
    """An imperfection whose size is varied.

    Attributes:
        name: in tables.
        title: in pictures and sentences.
        unit: of the levels.
        levels: sizes, from 0.
        stated: True if the robot can state it to the service, as a standard deviation of its pose.
    """

    name: str
    title: str
    unit: str
    levels: tuple[float, ...]
    stated: bool


DISTURBANCES = (
    Disturbance("robot_xy", "the robot's place (std in x and y)", "cm", (0.0, 1.0, 2.0, 3.0, 4.0, 5.0), True),
    Disturbance("robot_yaw", "the robot's heading (std)", "degrees", (0.0, 1.0, 2.0, 3.0, 4.0, 5.0), True),
    Disturbance("range_noise", "noise of ranges (std)", "mm", (0.0, 3.0, 10.0, 20.0, 30.0), False),
    Disturbance("clutter", "boxes that stand around the object", "boxes", (0.0, 1.0, 2.0, 4.0), False),
)


@dataclass(frozen=True)
class Point:
    """A trial at a level of a disturbance, under an update rule.

    Attributes:
        disturbance: its name.
        level: its size.
        stated: True if the robot stated the uncertainty of its pose to the service.
        rule: name of the update rule.
        object: name of the object.
        drop: index of the drop.
        sensor: name of the sensor configuration of the look; None: no look was worth more than min_gain.
        reason: why the scan was not accepted, or `nearest`; "" if it was accepted.
        grasp: name of the best grasp after the look.
        success: True if it lifted the object.
        blind: True if the best grasp without a look lifted the object.
    """

    disturbance: str
    level: float
    stated: bool
    rule: str
    object: str
    drop: int
    sensor: str | None
    reason: str
    grasp: str | None
    success: bool
    blind: bool


def disturbed(disturbance: str, level: float, trial: Trial, setting: Setting) -> Imperfections:
    """Return the imperfections of a trial at a level of a disturbance."""
    usual = setting.imperfections
    match disturbance:
        case "robot_xy":
            return replace(usual, robot_xy_m=level / 100.0)
        case "robot_yaw":
            return replace(usual, robot_yaw_rad=math.radians(level))
        case "range_noise":
            return replace(usual, range_noise_m=level / 1000.0)
        case _:
            return replace(usual, clutter=(*usual.clutter, *boxes(trial, round(level), setting.seed)))


def stated_at(disturbance: str, level: float) -> PoseUncertainty:
    """Return the standard deviations that a robot states which knows its disturbance."""
    if disturbance == "robot_xy":
        return PoseUncertainty(xy_m=level / 100.0)
    return PoseUncertainty(yaw_rad=math.radians(level))


def vary(client: Client, subjects: Sequence[Subject], setting: Setting, bar: Bar) -> tuple[Point, ...]:
    """Measure the curves of all disturbances, for every object and update rule.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
        UnstableSimulation: the simulation became unstable.
    """
    points: list[Point] = []
    for subject in subjects:
        with (
            bar(f"{subject.target.name}: disturbances", setting.sensitivity_drops) as advance,
            ThreadPoolExecutor(setting.threads) as pool,
        ):
            estimates = {
                rule: estimate_before_look(client, scenario, _uniform(len(scenario.poses)))
                for rule, scenario in subject.registered.scenarios.items()
            }
            for index in range(setting.sensitivity_drops):
                trial = make_trial(subject.target, "uniform", index, setting.imperfections, setting.seed)
                for rule, before in estimates.items():
                    points += _curves(client, subject, trial, rule, before, setting, pool)
                advance(1)
    return tuple(points)


def _uniform(count: int) -> list[float]:
    return [1.0 / count] * count


def _cases() -> list[tuple[str, float, bool]]:
    """All disturbances, their levels, and whether the robot states them."""
    return [
        (disturbance.name, level, stated)
        for disturbance in DISTURBANCES
        for level in disturbance.levels
        for stated in ((False, True) if disturbance.stated and level > 0.0 else (False,))
    ]


def _curves(
    client: Client,
    subject: Subject,
    trial: Trial,
    rule: str,
    before: EstimateBefore,
    setting: Setting,
    pool: ThreadPoolExecutor,
) -> list[Point]:
    look, blind = before.look, before.grasp
    index, name_of_object = trial.drop.index, trial.object
    without = attempted(subject, trial, blind) == "lifted"
    if look is None:
        return [
            Point(name, level, stated, rule, name_of_object, index, None, "", blind, without, without)
            for name, level, stated in _cases()
        ]
    scenario = subject.registered.scenarios[rule]
    sensor = next(sensor for sensor in scenario.sensors if sensor.name == look)
    scans: dict[tuple[str, float], Scan] = {
        (name, level): subject.bench.scan(trial, sensor, disturbed(name, level, trial, setting))
        for name, level, stated in _cases()
        if not stated
    }
    waiting = [
        pool.submit(
            estimate_after_look,
            client,
            scenario,
            trial.belief,
            sensor,
            scans[name, level],
            stated_at(name, level) if stated else None,
        )
        for name, level, stated in _cases()
    ]
    points = []
    for (name, level, stated), estimate in zip(_cases(), (each.result() for each in waiting), strict=True):
        grasp = estimate.best_grasp
        success = attempted(subject, trial, grasp) == "lifted"
        reason = estimate.update.reason or ""
        points.append(Point(name, level, stated, rule, name_of_object, index, look, reason, grasp, success, without))
    return points
