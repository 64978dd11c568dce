"""Views of the object from the places of a scenario: distances and flags that `places` judges."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.cutting import Contours, cut_poses
from voa_core.jit import kernel
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.rasterising import rasterise
from voa_core.scans import restrict_prediction
from voa_core.scenario import Scenario

Bools = NDArray[np.bool_]
Index = NDArray[np.intp]

_AROUND = BeamGrid(64, 0.0, 2.0 * np.pi / 64)


@dataclass(frozen=True, eq=False)
class View:
    """View of k poses of the object from one place.

    Attributes:
        sensor: the place.
        height_m: of its scan plane; None where predictions are given as data.
        seen: (k,) True if a beam returns from the object, within the range and the workspace.
        nearest: (k,) shortest range to the object on a beam, metres, without limit; inf for no hit, and for data.
        inside: (k,) True if the place lies inside the object, which is then hit in every direction.
        met: (k,) True if the scan plane meets the object.
        out: (k,) length by which the object reaches out of the workspace in the scan plane, metres; 0 without one.
    """

    sensor: SensorConfiguration
    height_m: float | None
    seen: Bools
    nearest: Floats
    inside: Bools
    met: Bools
    out: Floats


def views_from(
    scenario: Scenario, object_: Object | None, index: Index, sensors: Sequence[SensorConfiguration]
) -> list[View]:
    """View the poses `index` (k,) from those of the given places for which predictions can be made.

    The object is cut at one height after the other, and each height's cuts are dropped before the next.
    """
    views: dict[str, View] = {}
    by_height: dict[float, list[SensorConfiguration]] = {}
    for sensor in sensors:
        data, height = scenario.predictor.data.get(sensor.name), _height(scenario, sensor)
        if data is not None:
            views[sensor.name] = _of_data(scenario, sensor, data[index])
        elif height is not None:
            by_height.setdefault(height, []).append(sensor)
    if object_ is not None and scenario.poses.rotations is not None:
        poses = scenario.poses.subset(index)
        for height, at_height in by_height.items():
            views |= {view.sensor.name: view for view in _of_mesh(scenario, object_, poses, height, at_height)}
    return [views[sensor.name] for sensor in sensors if sensor.name in views]


def _height(scenario: Scenario, sensor: SensorConfiguration) -> float | None:
    return scenario.lidar.height_m if sensor.height_m is None else sensor.height_m


def _of_data(scenario: Scenario, sensor: SensorConfiguration, ranges: Floats) -> View:
    nothing, count = np.zeros(len(ranges), dtype=bool), len(ranges)
    seen = _seen(scenario, sensor, ranges)
    return View(sensor, None, seen, np.full(count, np.inf), nothing, ~nothing, np.zeros(count))


def _of_mesh(
    scenario: Scenario, object_: Object, poses: PoseSet, height: float, sensors: Sequence[SensorConfiguration]
) -> list[View]:
    cuts = cut_poses(object_, poses, height)
    met = np.diff(cuts.segment_start)[cuts.cut_of_pose] > 0
    out = np.zeros(len(poses))
    if scenario.workspace is not None:
        low, high = np.array(scenario.workspace.min), np.array(scenario.workspace.max)
        out = _reach_out(cuts.points, cuts.point_start, cuts.cut_of_pose, cuts.placement, low, high)
    views = []
    for sensor in sensors:
        ranges = rasterise(cuts, sensor, scenario.lidar.grid, np.inf)
        seen = _seen(scenario, sensor, ranges)
        views.append(View(sensor, height, seen, ranges.min(axis=1), _inside(cuts, sensor), met, out))
    return views


def _seen(scenario: Scenario, sensor: SensorConfiguration, ranges: Floats) -> Bools:
    lidar, workspace = scenario.lidar, scenario.workspace
    crossing = workspace.crossing(sensor, lidar.grid.angles) if workspace else None
    return any_along(1, np.isfinite(restrict_prediction(ranges, lidar.range_max, crossing)))


def _inside(cuts: Contours, sensor: SensorConfiguration) -> Bools:
    """True, (k,), if the sensor stands inside the contours of a pose: then every beam hits."""
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
    """True where any of the flags along an axis is set."""
    some: Bools = np.logical_or.reduce(flags, axis=axis)
    return some


def _boxes(cuts: Contours) -> tuple[Floats, Floats]:
    """Least and greatest x and y of every pose's contour in its own planar frame, (k, 2) each."""
    low = np.full((len(cuts.point_start) - 1, 2), np.inf)
    high = -low
    for cut, (start, end) in enumerate(zip(cuts.point_start[:-1], cuts.point_start[1:], strict=True)):
        if end > start:
            low[cut], high[cut] = cuts.points[start:end].min(axis=0), cuts.points[start:end].max(axis=0)
    return low[cuts.cut_of_pose], high[cuts.cut_of_pose]


@kernel
def _reach_out(
    points: Floats,
    point_start: NDArray[np.int64],
    cut_of_pose: NDArray[np.int64],
    placement: Floats,
    low: Floats,
    high: Floats,
) -> Floats:
    """Length by which the contour of each pose reaches out of the box from `low` to `high` (2,), (k,) metres."""
    out = np.zeros(len(cut_of_pose))
    for pose in range(len(cut_of_pose)):
        c, s, x0, y0 = placement[pose, 0], placement[pose, 1], placement[pose, 2], placement[pose, 3]
        cut = cut_of_pose[pose]
        for i in range(point_start[cut], point_start[cut + 1]):
            x, y = c * points[i, 0] - s * points[i, 1] + x0, s * points[i, 0] + c * points[i, 1] + y0
            out[pose] = max(out[pose], low[0] - x, x - high[0], low[1] - y, y - high[1])
    return out
