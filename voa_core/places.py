"""Places: looks that were taken from one place share their errors, and are weighed together.

A place keeps, for every displaced copy of every pose, the sum of the log weights of its looks. A pose's weight is the
mean over its copies of the product of these looks, so that a repeated look does not count as a new witness.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from voa_core.checks import Floats, frozen
from voa_core.filtering import log_means
from voa_core.lidars import LidarModel, SensorConfiguration

NEAR_M, NEAR_RAD, NEAR_HEIGHT_M = 0.02, math.radians(2.0), 0.01
_SLACK = 1e-9


@dataclass(frozen=True)
class Viewpoint:
    """Sensor pose from which a scan was taken.

    Attributes:
        listed: name of the scenario's own sensor configuration; None: a sensor pose of the scan's own.
        x, y: metres.
        yaw_rad: direction of beam angle 0.
        height_m: height of the scan plane; None: unknown.
    """

    listed: str | None
    x: float
    y: float
    yaw_rad: float
    height_m: float | None

    @classmethod
    def of(cls, sensor: SensorConfiguration, lidar: LidarModel, *, listed: bool) -> "Viewpoint":
        """Make the viewpoint of a sensor configuration; `listed` where it is one of the scenario's own."""
        height_m = lidar.height_m if sensor.height_m is None else sensor.height_m
        return cls(sensor.name if listed else None, sensor.x, sensor.y, sensor.yaw_rad, height_m)

    def shares_place(self, first: "Viewpoint") -> bool:
        """True if a look from here belongs to the place whose first look was taken from `first`.

        Looks from listed sensor configurations share a place by name; sensor poses do within 2 cm, 2 degrees and 1 cm
        of height. A listed sensor configuration and a sensor pose never share a place.
        """
        if self.listed is not None or first.listed is not None:
            return self.listed == first.listed
        turned = math.remainder(self.yaw_rad - first.yaw_rad, 2.0 * math.pi)
        raised = (self.height_m or 0.0) - (first.height_m or 0.0)
        return (
            math.hypot(self.x - first.x, self.y - first.y) <= NEAR_M + _SLACK
            and abs(turned) <= NEAR_RAD + _SLACK
            and abs(raised) <= NEAR_HEIGHT_M + _SLACK
        )


@dataclass(frozen=True, eq=False)
class Place:
    """A place that was looked from, and the weights of its looks together.

    Attributes:
        viewpoint: of its first look; None: unknown, so that no other look shares the place.
        looks: the numbers that its looks were given by the caller, in their order.
        log_sums: (n, J) sum over the looks of ln w of each displaced copy of each pose.
    """

    viewpoint: Viewpoint | None
    looks: tuple[int, ...]
    log_sums: Floats

    @property
    def copies(self) -> int:
        """Number J of displaced copies of each pose."""
        return int(self.log_sums.shape[1])

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.log_sums.nbytes

    @cached_property
    def log_weights(self) -> Floats:
        """Logarithms of the weights of the poses by all looks of the place, (n,): means over the copies."""
        return log_means(self.log_sums)

    def with_look(self, number: int, log_copies: Floats) -> "Place":
        """Add a look with ln w of each copy of each pose, (n, J) or (n, 1) where its copies are all alike.

        Raises:
            ValueError: look and place have different numbers of copies, and neither has one copy.
        """
        if log_copies.shape[1] != self.copies and 1 not in (log_copies.shape[1], self.copies):
            raise ValueError(
                f"the look has {log_copies.shape[1]} copies of each pose and its place {self.copies}: compare the "
                "scans of the one with fewer again (Scenario.evidence with copies=...)"
            )
        return Place(self.viewpoint, (*self.looks, number), frozen(self.log_sums + log_copies))


def index_of_place(places: Sequence[Place], viewpoint: Viewpoint | None) -> int | None:
    """Index of the oldest place that a look from the viewpoint shares; None: the look begins a place of its own."""
    return index_of_viewpoint([place.viewpoint for place in places], viewpoint)


def index_of_viewpoint(firsts: Sequence[Viewpoint | None], viewpoint: Viewpoint | None) -> int | None:
    """Index of the oldest place that a look from the viewpoint shares, from the viewpoints of the places' first looks.

    None: the look begins a place of its own.
    """
    if viewpoint is None:
        return None
    for index, first in enumerate(firsts):
        if first is not None and viewpoint.shares_place(first):
            return index
    return None


def log_increment(before: Place | None, after: Place, log_copies: Floats) -> Floats:
    """Logarithms of the weights that a look adds to its place, (n,): the mean after it divided by the mean before.

    Args:
        before: the place without the look; None: the look is its first.
        after: the place with the look.
        log_copies: (n, J) ln w of each copy of each pose by the look.
    """
    if after.copies == 1:
        return log_copies[:, 0]  # without rounding, as if the looks had nothing in common
    return after.log_weights if before is None else log_ratio(before, after)


def log_ratio(before: Place, after: Place) -> Floats:
    """Logarithms of the weights of the poses by a place, divided by those by another state of it, (n,).

    A pose that is impossible before is impossible after.
    """
    possible = before.log_weights > -np.inf
    ratio: Floats = np.full(len(possible), -np.inf)
    return np.subtract(after.log_weights, before.log_weights, out=ratio, where=possible)
