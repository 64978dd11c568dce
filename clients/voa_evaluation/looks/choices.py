"""Policies: from where to look, if at all. All meet the same drops, scans and attempts; only the look differs."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from voa_evaluation.looks.requests import Asked, Beforehand, expected_entropies
from voa_evaluation.looks.trials import Drop
from voa_msgs.geometry import SensorConfiguration

START_M = 1.0
"""How far from the middle of the table the sensor robot starts."""
POLICIES: Mapping[str, str] = MappingProxyType(
    {
        "voa": "the look with the highest Value of Assistance; none if no look is worth more than min_gain",
        "entropy": "the look after which the least entropy is expected over predicted scans",
        "beams": "the look from which most beams are expected to meet the object",
        "nearest": "the look nearest to where the robot happens to be, 1 m away on a random side",
        "random": "any look, each as likely",
        "none": "no look: grasp at once",
    }
)


def choices(asked: Asked, rule: str, drop: Drop, beforehand: Beforehand) -> dict[str, str | None]:
    """Which sensor configuration each policy looks from, by policy; None: no look. Ties: the first listed."""
    sensors = asked.scenarios[rule].sensors
    belief = np.asarray(drop.belief)
    # Rounded: what differs by a rounding error is a tie.
    entropies = np.round(expected_entropies(asked.likelihoods[rule], drop.belief), 9)
    return {
        "voa": beforehand.look,
        "entropy": sensors[int(np.argmin(entropies))].name,
        "beams": sensors[int(np.argmax(np.round(asked.visible @ belief, 9)))].name,
        "nearest": sensors[_nearest(sensors, drop.bearing_rad)].name,
        "random": sensors[drop.random_look].name,
        "none": None,
    }


def _nearest(sensors: Sequence[SensorConfiguration], bearing_rad: float) -> int:
    x, y = START_M * math.cos(bearing_rad), START_M * math.sin(bearing_rad)
    return int(np.argmin([math.hypot(sensor.x - x, sensor.y - y) for sensor in sensors]))
