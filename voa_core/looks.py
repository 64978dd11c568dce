"""Looks that are to come: their weights together, and what driving to them costs."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from voa_core.checks import number
from voa_core.choices import LookWeights
from voa_core.joint_weights import JointWeights
from voa_core.lidars import SensorConfiguration

LookOf = Callable[[SensorConfiguration, int], LookWeights]
"""A function that gives the weights after a number of scans in a row from a sensor configuration."""


def same_configuration(one: SensorConfiguration, other: SensorConfiguration) -> bool:
    """True if two sensor configurations have one name and one pose, whatever their costs."""
    return (one.name, one.x, one.y, one.yaw_rad, one.height_m) == (
        other.name,
        other.x,
        other.y,
        other.yaw_rad,
        other.height_m,
    )


@dataclass(frozen=True, eq=False)
class Looks:
    """Weights of looks that are to come, alone or together.

    Attributes:
        of: gives the weights after one scan or more in a row from a sensor configuration.
        pending: places of looks whose scans are on their way.
        same_place: True for two sensor configurations whose scans share their displacement.
    """

    of: LookOf
    pending: tuple[SensorConfiguration, ...] = ()
    same_place: Callable[[SensorConfiguration, SensorConfiguration], bool] = same_configuration

    def together(self, *sensors: SensorConfiguration) -> LookWeights:
        """Weights after the pending scans and one scan from each of the sensor configurations, in this order."""
        places: list[list[SensorConfiguration]] = []
        for sensor in (*self.pending, *sensors):
            same = [place for place in places if self.same_place(place[0], sensor)]
            if same:
                same[0].append(sensor)
            else:
                places.append([sensor])
        parts = tuple(self.of(place[0], len(place)) for place in places)
        return parts[0] if len(parts) == 1 else JointWeights(parts)

    def baseline(self) -> LookWeights | None:
        """Weights after the pending scans alone; None where nothing is pending."""
        return self.together() if self.pending else None


def exact_looks(weigher_of: Callable[[SensorConfiguration], LookWeights]) -> LookOf:
    """Make a function that gives the weights after scans in a row out of those after one exact scan.

    Exact scans have no common error: each counts by itself.
    """

    def of(sensor: SensorConfiguration, scans: int) -> LookWeights:
        weigher = weigher_of(sensor)
        return weigher if scans == 1 else JointWeights((weigher,) * scans)

    return of


@dataclass(frozen=True)
class Driving:
    """Costs of driving to a place in a straight line.

    Attributes:
        x, y: where the drive begins, metres.
        cost_per_m: success probability that a metre costs.
    """

    x: float
    y: float
    cost_per_m: float

    def __post_init__(self) -> None:
        number("from.x", self.x)
        number("from.y", self.y)
        number("cost_per_m", self.cost_per_m, at_least=0.0)

    def cost(self, sensor: SensorConfiguration) -> float:
        """Cost of driving to a sensor configuration, in success probability."""
        return self.cost_per_m * math.hypot(sensor.x - self.x, sensor.y - self.y)

    def onwards(self, sensor: SensorConfiguration) -> "Driving":
        """Costs of driving on from a sensor configuration."""
        return Driving(sensor.x, sensor.y, self.cost_per_m)


def cost_of(sensors: Sequence[SensorConfiguration], driving: Driving | None) -> float:
    """Cost of looks from these sensor configurations one after the other, with the drives between them."""
    total = 0.0
    for sensor in sensors:
        total += sensor.cost
        if driving is not None:
            total += driving.cost(sensor)
            driving = driving.onwards(sensor)
    return total
