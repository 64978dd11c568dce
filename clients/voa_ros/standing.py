"""Sensor configuration at which a robot stands, for people: the nearest one that a scenario lists."""

import math
from collections.abc import Iterable
from typing import Protocol

from voa_ros.motions import Planar, within

NEAR_M = 0.1
"""Distance up to which a robot counts as standing at a sensor configuration, metres."""
NEAR_RAD = math.radians(15.0)
"""Difference of the yaws up to which a robot counts as standing at a sensor configuration, radians."""


class NamedPlace(Planar, Protocol):
    """Protocol of a pose with a name."""

    @property
    def name(self) -> str:
        """Name of the pose."""


def nearest_place(pose: Planar, places: Iterable[NamedPlace]) -> str | None:
    """Return the name of the place nearest to a pose, within 10 cm and 15 degrees; None: there is none."""
    near = [place for place in places if within(pose, place, NEAR_M, NEAR_RAD)]
    nearest = min(near, key=lambda place: math.hypot(pose.x - place.x, pose.y - place.y), default=None)
    return None if nearest is None else nearest.name
