"""Mistakes between a pose and a place to look from: never seen, too near, too far, inside the object."""

from collections.abc import Callable, Sequence

import numpy as np

from voa_core.cutting import cut_poses
from voa_core.lidars import SensorConfiguration
from voa_core.mistakes.effort import Effort
from voa_core.mistakes.mistake import Kind, Mistake, length, listed
from voa_core.mistakes.picking import evenly
from voa_core.mistakes.views import Bools, Index, View, any_along, views_from
from voa_core.objects import Object
from voa_core.scenario import Scenario

_CUT_OFF_M = 1e-3
"""Length by which an object may reach out of the workspace without a warning, metres."""
_FEWEST_FACES, _FEWEST_POINTS = 7_000, 500  # a cut of fewer faces, and a view of fewer points, takes as long
_TRIED = 4


def mistakes_of_places(scenario: Scenario, object_: Object | None, effort: Effort) -> list[Mistake]:
    """Find probable mistakes between the poses and the scenario's own places.

    Args:
        scenario: with its places.
        object_: the mesh; None where all predictions are data.
        effort: limit of the search. If it is less than all pairs of pose and place, half of it goes to an even
            selection of pairs, and half to the questions that those leave open; other pairs are not judged.
    """
    picked, stood, left = _selection(scenario, object_, effort)
    places = [scenario.sensors[a] for a in stood]
    views = views_from(scenario, object_, picked, places)
    if not views:
        return []
    others = [scenario.sensors[a] for a in np.setdiff1d(np.arange(len(scenario.sensors)), stood)]
    mistakes = _pairs(scenario, picked, views)
    mistakes += _unseen_poses(scenario, object_, picked, views, others, left // 2)
    mistakes += _blind_places(scenario, object_, picked, views, left // 2)
    return mistakes + _planes(scenario, picked, views) + _cut_off(scenario, picked, views)


def _selection(scenario: Scenario, object_: Object | None, effort: Effort) -> tuple[Index, Index, int]:
    """Select the poses and places to search first, and the number of pairs that is left for open questions."""
    poses, places = len(scenario.poses), len(scenario.sensors)
    pairs, most_poses, most_heights = effort.pairs, poses, places
    heights = {sensor.height_m for sensor in scenario.sensors}
    if object_ is not None and scenario.poses.rotations is not None and scenario.poses.positions is not None:
        cuts = max(1, effort.cut_faces // max(len(object_.faces), _FEWEST_FACES))
        lying = np.column_stack([scenario.poses.rotations[:, 2], scenario.poses.positions[:, 2]])
        tilts = len(np.unique(np.round(lying, 12), axis=0))
        if tilts * len(heights) > cuts:
            most_poses, most_heights = max(1, cuts // len(heights)), cuts
        pairs = min(pairs, effort.contour_points // max(_points(scenario, object_), _FEWEST_POINTS))
    if poses * places <= pairs and most_poses == poses:
        return np.arange(poses), np.arange(places), 0
    half = max(1, pairs // 2)
    stood = evenly(places, min(most_heights, max(1, int(half**0.5), half // poses)))
    return evenly(poses, min(most_poses, max(1, half // len(stood)))), stood, half


def _points(scenario: Scenario, object_: Object) -> int:
    """Estimate the number of points of a cut of the object from a few of its poses."""
    height = next((sensor.height_m for sensor in scenario.sensors if sensor.height_m is not None), None)
    height = scenario.lidar.height_m if height is None else height
    if height is None:
        return 0
    tried = cut_poses(object_, scenario.poses.subset(evenly(len(scenario.poses), _TRIED)), height)
    return len(tried.points) // (len(tried.point_start) - 1)


def _pairs(scenario: Scenario, index: Index, views: list[View]) -> list[Mistake]:
    """Find places inside the object, and places nearer to it or farther from it than the lidar measures."""
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
            f"{lidar.range_min:g} m on: a shorter range counts as missing. Move the place away",
        ),
        (
            "place-too-far",
            lambda view: np.isfinite(view.nearest) & (view.nearest > lidar.range_max),
            "at pose {pose!r} the object is {nearest:.3g} m from sensor {sensor!r}, and the lidar measures up to "
            f"{lidar.range_max:g} m: it sees nothing. Move the place closer",
        ),
    ]
    mistakes = []
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
        mistakes.append(Mistake(kind, detail, *_named(scenario, index, views, wrong)))
    return mistakes


def _named(
    scenario: Scenario, index: Index, views: Sequence[View], wrong: Bools
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the poses and of the places that belong to a wrong pair, flags (places, poses)."""
    poses = tuple(scenario.poses.names[index[p]] for p in np.flatnonzero(any_along(0, wrong)))
    sensors = tuple(view.sensor.name for view, bad in zip(views, any_along(1, wrong), strict=True) if bad)
    return poses, sensors


def _unseen_poses(
    scenario: Scenario,
    object_: Object | None,
    picked: Index,
    views: list[View],
    others: list[SensorConfiguration],
    left: int,
) -> list[Mistake]:
    """Find poses that no place sees; poses that the selected places do not see are viewed from the `others` too."""
    unseen = picked[~any_along(0, np.stack([view.seen for view in views]))]
    if others and unseen.size:
        unseen = unseen[: left // len(others)]
        more = [view.seen for view in views_from(scenario, object_, unseen, others)] if unseen.size else []
        unseen = unseen[~any_along(0, np.stack(more))] if more else unseen
    if not unseen.size:
        return []
    names = tuple(scenario.poses.names[p] for p in unseen)
    detail = (
        f"no place sees the object at {listed('pose', names)}: every look at it resembles an empty table. Check the "
        "height of the scan plane, the yaw of the places, the workspace, and the pose itself"
    )
    return [Mistake("pose-never-seen", detail, poses=names)]


def _blind_places(
    scenario: Scenario, object_: Object | None, picked: Index, views: list[View], left: int
) -> list[Mistake]:
    """Find places that see no pose; places that see none of the selected poses are tried with the others too."""
    blind = [view.sensor for view in views if not view.seen.any()]
    others = np.setdiff1d(np.arange(len(scenario.poses)), picked)
    if others.size and blind:
        blind = blind[: left // len(others)]
        blind = [view.sensor for view in views_from(scenario, object_, others, blind) if not view.seen.any()]
    if not blind:
        return []
    names = tuple(sensor.name for sensor in blind)
    detail = (
        f"from {listed('sensor', names)} the object is seen at no pose: a look from there is no evidence. Check "
        "yaw_rad (radians, 0 along x), x, y and height_m"
    )
    return [Mistake("place-sees-nothing", detail, sensors=names)]


def _planes(scenario: Scenario, index: Index, views: list[View]) -> list[Mistake]:
    """Find poses that lie under or over a scan plane, one mistake for each height."""
    mistakes = []
    for height in dict.fromkeys(view.height_m for view in views if view.height_m is not None):
        at_height = [view for view in views if view.height_m == height]
        poses, sensors = _named(scenario, index, at_height, np.stack([~view.met for view in at_height]))
        if poses:
            detail = (
                f"the scan plane of {listed('sensor', sensors)} (at {height:g} m) does not meet the object at "
                f"{listed('pose', poses)}: from there the object is invisible. Lower or raise the lidar, or check "
                "position z"
            )
            mistakes.append(Mistake("plane-misses-object", detail, poses, sensors))
    return mistakes


def _cut_off(scenario: Scenario, index: Index, views: list[View]) -> list[Mistake]:
    """Find poses of which a part that the lidar could see lies outside of the workspace."""
    farthest = np.max([view.out for view in views], axis=0)
    wrong = np.flatnonzero(farthest > _CUT_OFF_M)
    if not wrong.size:
        return []
    names = tuple(scenario.poses.names[index[p]] for p in wrong)
    worst = int(np.argmax(farthest))
    detail = (
        f"at {listed('pose', names)} the object reaches out of the workspace, by {length(farthest[worst])} at "
        f"{scenario.poses.names[index[worst]]!r}: returns from outside of it do not count. Enlarge the workspace"
    )
    return [Mistake("workspace-misses-pose", detail, names)]
