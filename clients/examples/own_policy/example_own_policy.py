"""A policy of your own: look from the place that is farthest from all places visited before."""

import math
from dataclasses import dataclass

from voa_fleet.episodes.policies import Choice, Situation


@dataclass
class Opposite:
    """The look farthest from the robot and from all earlier looks, until the likeliest pose has 95 % of the belief."""

    name: str = "opposite"
    sure: float = 0.95

    def choose(self, situation: Situation, /) -> Choice:
        """Choose the unvisited place whose nearest visited place is farthest away; of equal ones the first listed."""
        if max(situation.belief) >= self.sure or not situation.unvisited:
            return Choice(None)
        visited = [(sensor.x, sensor.y) for sensor in situation.sensors if sensor.name in situation.visited]
        points = [*visited, (situation.robot.x, situation.robot.y)]
        farthest = max(
            situation.unvisited,
            key=lambda sensor: min(math.dist((sensor.x, sensor.y), point) for point in points),
        )
        return Choice(farthest.name)
