"""Preview of poses, places and scan planes under a person's choices."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from voa_core.checks import Floats
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.lidars import LidarPreset
from voa_msgs.objects import StablePose
from voa_setup.choices import Choices
from voa_setup.errors import InvalidOption
from voa_setup.heights import HeightSight, check_height, sights, suggested
from voa_setup.look.outlines import outlines
from voa_setup.mesh import SetupMesh
from voa_setup.places import footprints
from voa_setup.poses import PoseSet
from voa_setup.previews.messages import Outlines, Plan, PlaneSight, PlannedPlace, PlannedRest, RestOutline
from voa_setup.previews.mistakes import mistakes_before_grasps
from voa_setup.steps import chosen_places, chosen_poses

_MM = 1000.0
_STEP_MM = 0.5
"""Grid of the outlines: finer than a person sees, and coarse enough to bound the size of a path."""


def preview_plan(choices: Choices, mesh: SetupMesh, stable: Sequence[StablePose], lidar: LidarPreset) -> Plan:
    """Make the poses and places of a scenario, and compare the heights of the scan plane.

    Args:
        choices: of the person; those about grasps do not matter.
        mesh: in metres.
        stable: its stable poses.
        lidar: the preset that was chosen.

    Raises:
        InvalidOption: no rest is left.
    """
    poses = chosen_poses(choices, mesh, stable)
    try:
        places = chosen_places(choices, mesh, poses, lidar)
    except InvalidOption as error:
        return _plan(poses, problem=str(error))
    candidates = sights(mesh, poses.poses, poses.prior, places, lidar)
    chosen = None
    if choices.height_m is not None:
        chosen = sights(mesh, poses.poses, poses.prior, places, lidar, [choices.height_m])[0]
    problem = None
    best = suggested(candidates)
    try:
        check_height(chosen or best, candidates)
    except InvalidOption as error:
        problem = str(error)
    height_m = (chosen or best).height_m
    warnings = mistakes_before_grasps(mesh, poses, places, lidar, height_m, choices.xy_m)
    return _plan(poses, places, candidates, best, chosen or best, warnings, problem)


def preview_outlines(choices: Choices, mesh: SetupMesh, stable: Sequence[StablePose], height_m: float) -> Outlines:
    """Cut the object by the plane z = `height_m` at the first pose of each rest that is kept; raises InvalidOption."""
    poses = chosen_poses(choices, mesh, stable)
    named = {pose.name: pose for pose in poses.poses}
    firsts = {name: named[rest.poses[0]] for name, rest in poses.rests.items() if rest.poses}
    cuts = outlines(mesh.mesh, list(firsts.values()), height_m)
    shadows = footprints(mesh, list(firsts.values()))
    return Outlines(
        height_m=height_m,
        rests=[
            RestOutline(rest=name, path=_path_of_segments(cut), shadow=_path_around(points))
            for name, cut, points in zip(firsts, cuts, shadows, strict=True)
        ],
    )


def _plan(
    poses: PoseSet,
    places: Sequence[SensorConfiguration] = (),
    candidates: Sequence[HeightSight] = (),
    best: HeightSight | None = None,
    chosen: HeightSight | None = None,
    warnings: Sequence[str] = (),
    problem: str | None = None,
) -> Plan:
    """Write a plan as a message."""
    return Plan(
        rests=_planned_rests(poses),
        notes=[*poses.merged, *poses.left_out],
        problem=problem,
        places=[PlannedPlace(name=each.name, x=each.x, y=each.y, yaw_rad=each.yaw_rad) for each in places],
        planes=[_plane(each) for each in candidates],
        suggested=None if best is None or best.seen == 0.0 else _plane(best),
        chosen=None if chosen is None else _plane(chosen),
        warnings=list(warnings),
    )


def _planned_rests(poses: PoseSet) -> list[PlannedRest]:
    """List the rests that have poses, with the sum of the prior of each."""
    share = {pose.name: prior for pose, prior in zip(poses.poses, poses.prior, strict=True)}
    return [
        PlannedRest(name=name, poses=list(rest.poses), share=min(1.0, sum(share[pose] for pose in rest.poses)))
        for name, rest in poses.rests.items()
        if rest.poses
    ]


def _plane(sight: HeightSight) -> PlaneSight:
    return PlaneSight(height_m=sight.height_m, seen=sight.seen, pairs=sight.pairs, unseen=list(sight.unseen))


def _path_of_segments(segments: Floats) -> str:
    """Write segments (s, 2, 2), metres, as a path; those that fall together on a grid of 0.5 mm are written once."""
    grid = np.round(_MM * segments / _STEP_MM).astype(int)
    pairs = dict.fromkeys(tuple(sorted((tuple(start), tuple(end)))) for start, end in grid.tolist() if start != end)
    return "".join(
        f"M{_STEP_MM * x0:g} {_STEP_MM * y0:g}L{_STEP_MM * x1:g} {_STEP_MM * y1:g}" for (x0, y0), (x1, y1) in pairs
    )


def _path_around(points: Floats) -> str:
    """Write the convex hull of points (v, 2), metres, as a closed path."""
    corners = points[ConvexHull(points).vertices] * _MM
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in corners.tolist()) + "Z"
