"""Choices of the policies in a trial: all have the same drop, scans and attempts, and differ in the look alone."""

import math
from collections.abc import Callable, Sequence

from voa_evaluation.looks.requests import EstimateBefore, RegisteredObject
from voa_evaluation.looks.trials import Trial, random_source
from voa_fleet.episodes.policies import Situation, policy_named
from voa_msgs.geometry import SensorPose

START_M = 1.0
"""Distance from the middle of the table at which the sensor robot starts."""


def choices(
    policies: Sequence[str], registered: RegisteredObject, rule: str, trial: Trial, before: EstimateBefore
) -> dict[str, str | None]:
    """Let each policy choose its first look.

    Args:
        policies: their names.
        registered: the object's scenarios and forecasts.
        rule: name of the update rule.
        trial: with the belief and the robot's start.
        before: the service's estimate before any look.

    Returns:
        Name of the chosen sensor configuration by policy; None: no look.

    Raises:
        UnknownName: there is no such policy.
    """
    start = SensorPose(
        x=START_M * math.cos(trial.bearing_rad),
        y=START_M * math.sin(trial.bearing_rad),
        yaw_rad=trial.bearing_rad + math.pi,
    )
    return {
        name: policy_named(name)
        .choose(
            Situation(
                sensors=tuple(registered.scenarios[rule].sensors),
                visited=(),
                robot=start,
                belief=trial.belief,
                rank=lambda: before.ranking,
                forecast=lambda: registered.forecasts[rule],
                draw=_draw(name, trial),
            )
        )
        .sensor
        for name in policies
    }


def _draw(policy: str, trial: Trial) -> Callable[[int], int]:
    """Make the random source of a policy; `random` uses the draw that is stored in the trial, the same in every row."""
    if policy == "random":
        return lambda _count: trial.random_look
    rng = random_source(trial.drop.index, "policy", policy, trial.object, trial.kind)
    return lambda count: int(rng.integers(count))
