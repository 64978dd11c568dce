"""How much of a look's value is left when the world falls short: curves of success against one disturbance each.

The look is the one that VOA recommends, which knows nothing of the disturbance. Drops, scans and attempts share their
random numbers between levels.
"""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from voa_client import Client
from voa_evaluation.looks.requests import after_a_look, before_any_look
from voa_evaluation.looks.trials import Drop, boxes, make_drop
from voa_evaluation.looks.running import Bar, Subject, attempted
from voa_evaluation.looks.setting import Setting
from voa_fleet.world.imperfections import Imperfections
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.sessions import Scan


@dataclass(frozen=True)
class Disturbance:
    """One target that goes wrong, by degrees.

    Attributes:
        levels: in `unit`.
        stated: whether the robot can tell the service of it, as a standard deviation of its pose.
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
    """One drop at one level of a disturbance, under one rule.

    Attributes:
        stated: whether the service was told how uncertain the pose is.
        sensor: where the look was from; None: no look was worth more than min_gain.
        reason: why the scan was not accepted, or `nearest`; "" if it was.
        grasp: the best one afterwards.
        success: whether it lifted the object.
        blind: whether the best grasp without a look did.
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


def disturbed(disturbance: str, level: float, drop: Drop, setting: Setting) -> Imperfections:
    """What goes wrong at a level of a disturbance."""
    imperfections = setting.imperfections
    match disturbance:
        case "robot_xy":
            return replace(imperfections, robot_xy_m=level / 100.0)
        case "robot_yaw":
            return replace(imperfections, robot_yaw_rad=math.radians(level))
        case "range_noise":
            return replace(imperfections, range_noise_m=level / 1000.0)
        case _:
            return replace(imperfections, clutter=(*imperfections.clutter, *boxes(drop, round(level), setting.seed)))


def stated_at(disturbance: str, level: float) -> PoseUncertainty:
    """What a robot that knows of its disturbance states."""
    if disturbance == "robot_xy":
        return PoseUncertainty(xy_m=level / 100.0)
    return PoseUncertainty(yaw_rad=math.radians(level))


def vary(client: Client, subjects: Sequence[Subject], setting: Setting, bar: Bar) -> tuple[Point, ...]:
    """All curves.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
        UnstableSimulation: the physics exploded.
    """
    points: list[Point] = []
    for subject in subjects:
        with (
            bar(f"{subject.target.name}: disturbances", setting.sensitivity_drops) as advance,
            ThreadPoolExecutor(setting.threads) as pool,
        ):
            looks = {
                rule: before_any_look(client, scenario, _even(len(scenario.poses)))
                for rule, scenario in subject.asked.scenarios.items()
            }
            for index in range(setting.sensitivity_drops):
                drop = make_drop(subject.target, "uniform", index, setting.imperfections, setting.seed)
                for rule, told in looks.items():
                    points += _curves(client, subject, drop, rule, told.look, told.grasp, setting, pool)
                advance(1)
    return tuple(points)


def _even(count: int) -> list[float]:
    return [1.0 / count] * count


def _curves(
    client: Client,
    subject: Subject,
    drop: Drop,
    rule: str,
    look: str | None,
    blind: str | None,
    setting: Setting,
    pool: ThreadPoolExecutor,
) -> list[Point]:
    cases = [
        (disturbance.name, level, stated)
        for disturbance in DISTURBANCES
        for level in disturbance.levels
        for stated in ((False, True) if disturbance.stated and level > 0.0 else (False,))
    ]
    without = attempted(subject, drop, blind) == "lifted"
    if look is None:
        return [
            Point(name, level, stated, rule, drop.object, drop.index, None, "", blind, without, without)
            for name, level, stated in cases
        ]
    scenario = subject.asked.scenarios[rule]
    sensor = next(sensor for sensor in scenario.sensors if sensor.name == look)
    scans: dict[tuple[str, float], Scan] = {
        (name, level): subject.table.scan(drop, sensor, disturbed(name, level, drop, setting))
        for name, level, stated in cases
        if not stated
    }
    waiting = [
        pool.submit(
            after_a_look,
            client,
            scenario,
            drop.belief,
            sensor,
            scans[name, level],
            stated_at(name, level) if stated else None,
        )
        for name, level, stated in cases
    ]
    points = []
    for (name, level, stated), answer in zip(cases, (each.result() for each in waiting), strict=True):
        grasp = answer.best_grasp
        success = attempted(subject, drop, grasp) == "lifted"
        reason = answer.update.reason or ""
        points.append(Point(name, level, stated, rule, drop.object, drop.index, look, reason, grasp, success, without))
    return points
