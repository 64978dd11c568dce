"""Measures of a scenario by which its scene is laid out: the middle of its poses, and how far its places reach."""

import math
from dataclasses import dataclass

from voa_msgs.scenarios import Scenario

_SMALLEST_M = 0.15
_MARGIN = 1.25


@dataclass(frozen=True)
class Measures:
    """Middle and reach of a scenario on the table.

    Attributes:
        middle: x, y of the middle of the poses, or of the places if the poses have no geometry, metres.
        reach: distance from the middle to the farthest place or pose, metres, at least 0.15.
    """

    middle: tuple[float, float]
    reach: float

    @property
    def table(self) -> float:
        """Edge of the square of table that the scene shows, metres."""
        return 2.0 * _MARGIN * self.reach


def measures_of(scenario: Scenario) -> Measures:
    """Measure a scenario; the result is the same for all versions of its sessions."""
    poses = [pose.position[:2] for pose in scenario.poses if pose.position is not None]
    stands = [(sensor.x, sensor.y) for sensor in scenario.sensors]
    centred = poses or stands
    middle = (sum(x for x, _ in centred) / len(centred), sum(y for _, y in centred) / len(centred))
    reach = max(math.dist(middle, point) for point in [*poses, *stands])
    return Measures(middle, max(reach, _SMALLEST_M))
