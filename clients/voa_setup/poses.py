"""Poses of a scenario: rests, each at several yaws and positions on the table, without twins, and their prior."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.geometry import quaternion_of_matrix
from voa_fleet.world.objects import Rest
from voa_msgs.objects import StablePose
from voa_msgs.scenarios import Pose
from voa_setup.errors import InvalidOption
from voa_setup.mesh import SetupMesh
from voa_setup.rests import NamedRest, name_rests
from voa_setup.symmetry import Symmetry, symmetry_of

LEAST_PROBABILITY = 0.02
"""Probability below which a rest is left out."""
_BALL = (
    "The object is a ball: it can rest in infinitely many orientations, which look the same and are grasped alike; one "
    "pose stands for them, and no look can help."
)
_DIGITS = 9
_POSITION_DIGITS = 6  # micrometres


@dataclass(frozen=True, eq=False)
class PoseSet:
    """Poses of a scenario, and what was merged or left out.

    Attributes:
        poses: by rest, then position, then yaw.
        prior: probability of each pose, (poses,); sums to 1.
        rests: ways to rest by name, with the poses of each; without poses where the scenario leaves a rest out.
        merged: sentences about poses that look the same and were merged.
        left_out: sentences about rests that were left out.
    """

    poses: list[Pose]
    prior: list[float]
    rests: dict[str, Rest]
    merged: list[str]
    left_out: list[str]


def even_yaws(count: int) -> list[float]:
    """Return that many yaws from 0, evenly over a turn, in degrees."""
    return [360.0 * index / count for index in range(count)]


def make_poses(
    mesh: SetupMesh,
    stable: Sequence[StablePose],
    *,
    yaws_deg: Sequence[float],
    positions: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    least_probability: float = LEAST_PROBABILITY,
    rests: Sequence[str] | None = None,
) -> PoseSet:
    """Make a pose of each rest at each yaw and position; keep one of those at which the mesh lies in the same place.

    Args:
        mesh: of the object.
        stable: its stable poses.
        yaws_deg: turns about the vertical through the centre of mass, degrees.
        positions: x, y over which the centre of mass lies, metres.
        least_probability: rests less probable than this are left out.
        rests: names of the rests to keep, however probable; None: all that are probable enough.

    Raises:
        InvalidOption: no rest is as probable as `least_probability`, or a name is that of no rest.
    """
    symmetry = symmetry_of(mesh.object_)
    named = name_rests(stable, symmetry, ball=mesh.is_ball)
    kept = _kept(named, least_probability, rests)
    poses: list[Pose] = []
    prior: list[float] = []
    ways: dict[str, Rest] = {}
    merged: list[str] = [_BALL] if mesh.is_ball else []
    total = sum(rest.probability for rest in kept)
    for rest in kept:
        merged += _merged_rests(rest)
        groups = _alike_yaws(rest, list(yaws_deg), symmetry)
        merged += [] if mesh.is_ball else _merged_yaws(rest, groups)
        names = []
        for x, y in positions:
            for group in groups:
                names.append(_pose_name(rest, group[0], len(groups), (x, y) if len(positions) > 1 else None))
                poses.append(_pose(names[-1], rest.at(math.radians(group[0]), x, y)))
                prior.append(rest.probability / total * len(group) / (len(yaws_deg) * len(positions)))
        ways[rest.name] = Rest(poses=names, ups=list(rest.ups))
    left_out = [rest for rest in named if rest not in kept]
    ways |= {rest.name: Rest(poses=[], ups=list(rest.ups)) for rest in left_out}
    return PoseSet(poses, [round(share, _DIGITS) for share in prior], ways, merged, _reasons(left_out))


def _kept(named: Sequence[NamedRest], least_probability: float, names: Sequence[str] | None) -> list[NamedRest]:
    """Select the rests of those names, or those that are probable enough; raises InvalidOption."""
    if names is None:
        kept = [rest for rest in named if rest.probability >= least_probability]
        if not kept:
            raise InvalidOption(
                f"no rest is as probable as {least_probability:g}; the most probable, {named[0].name!r}, has "
                f"{named[0].probability:.3f}"
            )
        return kept
    known = [rest.name for rest in named]
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        wrong = f"there is no rest {unknown[0]!r}" if unknown else "expected at least one rest"
        raise InvalidOption(f"--rests: {wrong}; there are: {', '.join(map(repr, known))}")
    return [rest for rest in named if rest.name in names]


def _alike_yaws(rest: NamedRest, yaws_deg: list[float], symmetry: Symmetry) -> list[list[float]]:
    """Group the yaws at which the mesh lies in the same place; each group begins with the first listed."""
    groups: list[list[float]] = []
    same: dict[float, bool] = {}  # by the turn between two yaws, which alone decides
    for yaw in yaws_deg:
        for group in groups:
            apart = round((yaw - group[0]) % 360.0, 6)
            if apart not in same:
                turned = rest.at(math.radians(apart), 0.0, 0.0)
                same[apart] = symmetry.alike(rest.transform, turned)
            if same[apart]:
                group.append(yaw)
                break
        else:
            groups.append([yaw])
    return groups


def _pose_name(rest: NamedRest, yaw_deg: float, yaws: int, position: tuple[float, float] | None) -> str:
    yaw = f" {yaw_deg:g}" if yaws > 1 else ""
    return f"{rest.name}{yaw}" + ("" if position is None else f" at {position[0]:g},{position[1]:g}")


def _pose(name: str, transform: Floats) -> Pose:
    """Write a pose with few digits, so that it reads well and depends on no last bit."""
    quaternion = np.round(quaternion_of_matrix(transform[:3, :3]), _DIGITS) + 0.0
    position = np.round(transform[:3, 3], _POSITION_DIGITS) + 0.0
    return Pose(name=name, position=position.tolist(), quaternion_wxyz=quaternion.tolist())


def _merged_rests(rest: NamedRest) -> list[str]:
    if len(rest.ups) == 1:
        return []
    return [f"{rest.name!r} stands for {len(rest.ups)} rests that look the same."]


def _merged_yaws(rest: NamedRest, groups: list[list[float]]) -> list[str]:
    """Say which yaws of a rest look the same."""
    twins = [group for group in groups if len(group) > 1]
    if not twins:
        return []
    if len(groups) == 1:
        return [f"{rest.name!r} looks the same at all {len(groups[0])} yaws: one pose stands for them."]
    pairs = [f"{group[0]:g} for {', '.join(f'{yaw:g}' for yaw in group[1:])}" for group in twins]
    return [f"{rest.name!r} looks the same at several yaws: {'; '.join(pairs)} (degrees)."]


def _reasons(left_out: Sequence[NamedRest]) -> list[str]:
    return [
        f"{rest.name!r} is left out: the object comes to rest that way with probability {rest.probability:.3f}."
        for rest in left_out
    ]
