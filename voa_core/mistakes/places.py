"""Mistakes that show only between a pose and a place to look from: what is never seen, too near, too far, inside."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from voa_core.cutting import Contours, cut_poses
from voa_core.lidars import SensorConfiguration
from voa_core.mistakes.found import Kind, Mistake, listed
from voa_core.mistakes.picking import evenly
from voa_core.mistakes.views import Bools, CutsAt, View, any_along, view_from, world_boxes
from voa_core.objects import Object
from voa_core.scenario import Scenario

_CUT_OFF_M = 1e-3
"""An object that reaches farther than this out of the workspace is cut by it."""

Index = NDArray[np.intp]


def mistakes_of_places(scenario: Scenario, object_: Object | None, most_pairs: int | None) -> list[Mistake]:
    """Find what is wrong between the poses and the scenario's own places.

    Args:
        scenario: with its places.
        object_: the mesh; None where all predictions are data.
        most_pairs: pairs of pose and place to look at; None: all. With fewer pairs than there are, half of them are
            a regular selection, and the other half is kept for what the selection leaves open.
    """
    poses, places = len(scenario.poses), len(scenario.sensors)
    if most_pairs is None or poses * places <= most_pairs:
        picked, stood, left = np.arange(poses), np.arange(places), 0
    else:
        left = most_pairs // 2
        stood = evenly(places, max(1, int(left**0.5)))
        picked = evenly(poses, left // len(stood))
    cuts_at = _cuts_of(scenario, object_, picked)
    views = [view for a in stood if (view := view_from(scenario, scenario.sensors[a], picked, cuts_at)) is not None]
    if not views:
        return []
    found = _pairs(scenario, picked, views)
    found += _never_seen(scenario, object_, picked, views, stood, left)
    if cuts_at is not None:
        found += _planes(scenario, picked, views)
        found += _cut_off(scenario, picked, views, cuts_at)
    return found


def _cuts_of(scenario: Scenario, object_: Object | None, index: Index) -> CutsAt | None:
    """The cuts of some of the poses by height, each made once."""
    if object_ is None or scenario.poses.rotations is None:
        return None
    poses, mesh = scenario.poses.subset(index), object_

    @cache
    def cuts_at(height: float) -> Contours:
        return cut_poses(mesh, poses, height)

    return cuts_at


def _pairs(scenario: Scenario, index: Index, views: list[View]) -> list[Mistake]:
    """Places inside the object, nearer to it than the lidar measures, or farther."""
    lidar = scenario.lidar
    checks: list[tuple[Kind, Callable[[View], Bools], str]] = [
        (
            "place-inside-object",
            lambda view: view.inside,
            "sensor {sensor!r} stands inside the object at pose {pose!r}: move the place, or the pose",
        ),
        (
            "place-too-near",
            lambda view: (view.nearest < lidar.range_min) & ~view.inside,
            "at pose {pose!r} the object is {nearest:.3g} m from sensor {sensor!r}, and the lidar measures from "
            f"{lidar.range_min:g} m on: what is nearer counts as missing. Move the place away",
        ),
        (
            "place-too-far",
            lambda view: np.isfinite(view.nearest) & (view.nearest > lidar.range_max),
            "at pose {pose!r} the object is {nearest:.3g} m from sensor {sensor!r}, and the lidar measures up to "
            f"{lidar.range_max:g} m: it sees nothing. Move the place closer",
        ),
    ]
    found = []
    for kind, wrong_in, sentence in checks:
        wrong = np.stack([wrong_in(view) for view in views])  # (places, poses)
        if not wrong.any():
            continue
        first, pose = (int(i) for i in np.argwhere(wrong)[0])
        detail = sentence.format(
            sensor=views[first].sensor.name,
            pose=scenario.poses.names[index[pose]],
            nearest=views[first].nearest[pose],
        )
        others = int(wrong.sum()) - 1
        detail += f" ({others} more such pair{'s' * (others > 1)} of pose and place)" if others else ""
        poses = tuple(scenario.poses.names[index[p]] for p in np.flatnonzero(any_along(0, wrong)))
        sensors = tuple(view.sensor.name for view, bad in zip(views, any_along(1, wrong), strict=True) if bad)
        found.append(Mistake(kind, detail, poses, sensors))
    return found


def _never_seen(
    scenario: Scenario, object_: Object | None, picked: Index, views: list[View], stood: Index, left: int
) -> list[Mistake]:
    """Poses that no place sees, and places that see no pose.

    Where the selection shows none, the poses and places that it left out are looked at too, while `left` pairs last.
    """
    seen = np.stack([view.seen for view in views])
    unseen, blind = picked[~any_along(0, seen)], [view.sensor for view in views if not view.seen.any()]
    other_places = [scenario.sensors[a] for a in np.setdiff1d(np.arange(len(scenario.sensors)), stood)]
    other_poses = np.setdiff1d(np.arange(len(scenario.poses)), picked)
    unseen = unseen[: left // len(other_places)] if other_places else unseen
    unseen = unseen[~any_along(0, _seen_from(scenario, object_, unseen, other_places))]
    left -= len(unseen) * len(other_places)
    blind = blind[: max(0, left) // len(other_poses)] if len(other_poses) else blind
    still = ~any_along(1, _seen_from(scenario, object_, other_poses, blind))
    sensors = tuple(sensor.name for sensor, is_blind in zip(blind, still, strict=True) if is_blind)
    found = []
    if unseen.size:
        names = tuple(scenario.poses.names[p] for p in unseen)
        detail = (
            f"no place sees the object at {listed('pose', names)}: no look can tell it from an empty table. Check the "
            "height of the scan plane, the yaw of the places, the workspace, and the pose itself"
        )
        found.append(Mistake("pose-never-seen", detail, poses=names))
    if sensors:
        detail = (
            f"from {listed('sensor', sensors)} the object is seen at no pose: a look from there tells nothing. Check "
            "yaw_rad (radians, 0 along x), x, y and height_m"
        )
        found.append(Mistake("place-sees-nothing", detail, sensors=sensors))
    return found


def _seen_from(scenario: Scenario, object_: Object | None, index: Index, sensors: list[SensorConfiguration]) -> Bools:
    """Whether each place sees each of the poses `index`, (places, poses)."""
    cuts_at = _cuts_of(scenario, object_, index)
    views = [view_from(scenario, sensor, index, cuts_at) for sensor in sensors] if index.size else []
    seen = [view.seen for view in views if view is not None]
    return np.stack(seen) if seen else np.zeros((len(sensors), len(index)), dtype=bool)


def _planes(scenario: Scenario, index: Index, views: list[View]) -> list[Mistake]:
    """Poses that lie under or over the scan plane of a place."""
    missed = ~np.stack([view.met for view in views])
    if not missed.any():
        return []
    of_places = any_along(1, missed)
    poses = tuple(scenario.poses.names[index[p]] for p in np.flatnonzero(any_along(0, missed)))
    sensors = tuple(view.sensor.name for view, misses in zip(views, of_places, strict=True) if misses)
    height = next(view.height_m for view, misses in zip(views, of_places, strict=True) if misses)
    detail = (
        f"the scan plane of {listed('sensor', sensors)} (at {height:g} m) does not meet the object at "
        f"{listed('pose', poses)}: from there the object is invisible. Lower or raise the lidar, or check position z"
    )
    return [Mistake("plane-misses-object", detail, poses, sensors)]


def _cut_off(scenario: Scenario, index: Index, views: list[View], cuts_at: CutsAt) -> list[Mistake]:
    """Poses of which a part that the lidar could see lies outside of the workspace."""
    if scenario.workspace is None:
        return []
    low, high = np.array(scenario.workspace.min), np.array(scenario.workspace.max)
    farthest = np.zeros(len(index))
    for height in {view.height_m for view in views if view.height_m is not None}:
        least, greatest = world_boxes(cuts_at(height))
        out = np.maximum(low - least, greatest - high).max(axis=1)
        farthest = np.maximum(farthest, np.where(np.isfinite(out), out, 0.0))
    wrong = np.flatnonzero(farthest > _CUT_OFF_M)
    if not wrong.size:
        return []
    names = tuple(scenario.poses.names[index[p]] for p in wrong)
    worst = int(np.argmax(farthest))
    detail = (
        f"at {listed('pose', names)} the object reaches out of the workspace, by {1e3 * farthest[worst]:.4g} mm at "
        f"{scenario.poses.names[index[worst]]!r}: what is outside counts as nothing. Enlarge the workspace"
    )
    return [Mistake("workspace-misses-pose", detail, names)]
