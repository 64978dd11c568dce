"""What the lidar would see of the object at some poses from one place: the numbers that mistakes are told by."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.cutting import Contours
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.rasterising import rasterise
from voa_core.scans import restrict_prediction
from voa_core.scenario import Scenario

Bools = NDArray[np.bool_]
CutsAt = Callable[[float], Contours]
"""The cuts of the poses that are looked at, by height."""

_AROUND = BeamGrid(64, 0.0, 2.0 * np.pi / 64)


@dataclass(frozen=True, eq=False)
class View:
    """The k poses that are looked at, from one place.

    Attributes:
        sensor: the place.
        height_m: of its scan plane; None where given predictions need none.
        seen: (k,) whether a beam returns from the object, within the range and the workspace.
        nearest: (k,) range of the nearest hit on a beam, however far, metres; inf for none, and for given predictions.
        inside: (k,) whether the place lies inside the object, so that it is hit in every direction.
        met: (k,) whether the scan plane meets the object.
    """

    sensor: SensorConfiguration
    height_m: float | None
    seen: Bools
    nearest: Floats
    inside: Bools
    met: Bools


def view_from(
    scenario: Scenario, sensor: SensorConfiguration, index: NDArray[np.intp], cuts_at: CutsAt | None
) -> View | None:
    """Look at the poses `index` (k,) from one of the scenario's places; None where nothing can be predicted.

    Args:
        scenario: whose lidar, workspace and given predictions hold.
        sensor: one of the scenario's own configurations.
        index: the poses.
        cuts_at: the cuts of those very poses; None: there is no mesh.
    """
    lidar, data = scenario.lidar, scenario.predictor.data.get(sensor.name)
    height = lidar.height_m if sensor.height_m is None else sensor.height_m
    if data is not None:
        ranges, nothing = data[index], np.zeros(len(index), dtype=bool)
        view = View(sensor, None, nothing, np.full(len(index), np.inf), nothing, ~nothing)
    elif cuts_at is None or height is None:
        return None
    else:
        cuts = cuts_at(height)
        ranges = rasterise(cuts, sensor, lidar.grid, np.inf)
        met = np.diff(cuts.segment_start)[cuts.cut_of_pose] > 0
        view = View(sensor, height, met, ranges.min(axis=1), _inside(cuts, sensor), met)
    crossing = scenario.workspace.crossing(sensor, lidar.grid.angles) if scenario.workspace else None
    seen = any_along(1, np.isfinite(restrict_prediction(ranges, lidar.range_max, crossing)))
    return replace(view, seen=seen)


def _inside(cuts: Contours, sensor: SensorConfiguration) -> Bools:
    """Whether the sensor stands inside each pose's contours: then it is hit whichever way it looks."""
    low, high = _boxes(cuts)
    dx, dy = sensor.x - cuts.placement[:, 2], sensor.y - cuts.placement[:, 3]
    c, s = cuts.placement[:, 0], cuts.placement[:, 1]
    local = np.column_stack([c * dx + s * dy, c * dy - s * dx])
    outside = any_along(1, (local < low) | (local > high))
    some = np.flatnonzero(~outside)
    if some.size:
        near = replace(cuts, cut_of_pose=cuts.cut_of_pose[some], placement=cuts.placement[some])
        outside[some] = np.isinf(rasterise(near, sensor, _AROUND, np.inf).max(axis=1))
    return ~outside


def any_along(axis: int, flags: Bools) -> Bools:
    """Whether any of the flags along an axis is set."""
    found: Bools = np.logical_or.reduce(flags, axis=axis)
    return found


def _boxes(cuts: Contours) -> tuple[Floats, Floats]:
    """Least and greatest x and y of every pose's contour in its own planar frame, (k, 2) each."""
    low = np.full((len(cuts.point_start) - 1, 2), np.inf)
    high = -low
    for cut, (start, end) in enumerate(zip(cuts.point_start[:-1], cuts.point_start[1:], strict=True)):
        if end > start:
            low[cut], high[cut] = cuts.points[start:end].min(axis=0), cuts.points[start:end].max(axis=0)
    return low[cuts.cut_of_pose], high[cuts.cut_of_pose]


def world_boxes(cuts: Contours) -> tuple[Floats, Floats]:
    """Least and greatest x and y of every pose's contour in the world, (k, 2) each; inf and -inf where it has none."""
    low = np.full((len(cuts.cut_of_pose), 2), np.inf)
    high = -low
    for pose, cut in enumerate(cuts.cut_of_pose):
        points = cuts.points[cuts.point_start[cut] : cuts.point_start[cut + 1]]
        if len(points):
            c, s, x, y = cuts.placement[pose]
            placed = np.column_stack([c * points[:, 0] - s * points[:, 1] + x, s * points[:, 0] + c * points[:, 1] + y])
            low[pose], high[pose] = placed.min(axis=0), placed.max(axis=0)
    return low, high
