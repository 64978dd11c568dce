"""The workspace: a box in the world frame outside which a return is not the object."""

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats, finite_array
from voa_core.errors import InvalidInput
from voa_core.lidars import SensorConfiguration

_EDGE_M = 1e-9


@dataclass(frozen=True)
class Crossing:
    """Distances in metres at which each beam enters and leaves the workspace, shape (beams,).

    A beam that never crosses has `enter = inf` and `leave = -inf`.
    """

    enter: Floats
    leave: Floats

    def before(self, ranges: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Flags of ranges (..., beams) that end before their beam enters the box; False on a beam that never enters."""
        return (ranges < self.enter - _EDGE_M) & np.isfinite(self.enter)

    def inside(self, ranges: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Flags of ranges (..., beams) that end inside the box."""
        return (ranges >= self.enter - _EDGE_M) & (ranges <= self.leave + _EDGE_M)


@dataclass(frozen=True)
class Workspace:
    """An axis-aligned box over the table, from `min` to `max`, metres in the world frame; raises InvalidInput."""

    min: tuple[float, float]
    max: tuple[float, float]

    def __post_init__(self) -> None:
        low, high = (
            finite_array("workspace.min", self.min, (2,)),
            finite_array("workspace.max", self.max, (2,)),
        )
        if not (low < high).all():
            raise InvalidInput("workspace", "min below max in x and y", f"min {self.min}, max {self.max}")

    def crossing(self, sensor: SensorConfiguration, angles: Floats) -> Crossing:
        """Compute where the beams at `angles` (r,), radians in the sensor's frame, cross the box (the slab method)."""
        heading = sensor.yaw_rad + angles
        enter, leave = np.zeros(len(angles)), np.full(len(angles), np.inf)
        for axis, direction in enumerate((np.cos(heading), np.sin(heading))):
            start = (sensor.x, sensor.y)[axis]
            with np.errstate(divide="ignore", invalid="ignore"):
                near = (self.min[axis] - start) / direction
                far = (self.max[axis] - start) / direction
            # A beam that is parallel to the slab lies inside it along its whole length, or nowhere.
            along = direction == 0.0
            always = self.min[axis] <= start <= self.max[axis]
            near = np.where(along, -np.inf if always else np.inf, near)
            far = np.where(along, np.inf if always else -np.inf, far)
            enter = np.maximum(enter, np.where(along, near, np.minimum(near, far)))
            leave = np.minimum(leave, np.where(along, far, np.maximum(near, far)))
        missed = enter > leave
        return Crossing(np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave))
