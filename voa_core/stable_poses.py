"""How an object can rest on the table, and how probable each way is.

The raw proposals are those of `trimesh.poses.compute_stable_poses` (quasi-static, Goldberg et al., "Part pose
statistics", 1999): one per facet of the convex hull that the object can rest on. A curved side is many
facets, yet the object rolls over their edges at a breath: the physically distinct ways to rest are the
basins of the height of the centre of mass that need a real push to leave.
"""

from dataclasses import dataclass

import numpy as np
import trimesh

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.geometry import quaternion_of_matrix, upright_rotation
from voa_core.objects import Object

_PUSH = 0.01  # of the object's size: a centre of mass that must rise by less does not hold the object
_ARC_STEP_RAD = np.radians(0.5)


@dataclass(frozen=True)
class StablePose:
    """One way to rest on z = 0: object frame in the world, and the probability of landing so."""

    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, float, float, float]
    probability: float


def propose_stable_poses(object_: Object) -> list[StablePose]:
    """The physically distinct ways to rest, most probable first; probabilities sum to 1.

    Poses between which the centre of mass rises by less than 1 % of the object's size are one; it is
    represented by the one with the lowest centre of mass and gets their summed probability.

    Raises:
        InvalidInput: the mesh has no volume to rest on (flat, or fewer than four points).
    """
    mesh = trimesh.Trimesh(object_.vertices, object_.faces, process=False)
    try:
        hull = mesh.convex_hull
        centre = _centre_of_mass([mesh, hull] if object_.watertight else [hull], hull)
        transforms, probabilities = trimesh.poses.compute_stable_poses(hull, center_mass=centre, seed=0)
        ups = np.array(transforms)[:, 2, :3]
    except Exception as error:  # scipy's Qhull raises several kinds
        raise InvalidInput("object", "a mesh with a volume", "one without a convex hull") from error
    corners = np.asarray(hull.vertices) - centre
    heights = _centre_heights(ups, corners)
    home = _basins(ups, heights, corners, _PUSH * float(np.linalg.norm(np.ptp(corners, axis=0))))
    total = float(np.sum(probabilities))
    poses = [
        _resting(ups[root], heights[root], centre, float(np.sum(probabilities[home == root])) / total)
        for root in np.unique(home)
    ]
    return sorted(poses, key=lambda pose: -pose.probability)


def _centre_of_mass(candidates: list[trimesh.Trimesh], hull: trimesh.Trimesh) -> Floats:
    """That of the first whose faces all point outwards, told by its lying inside the hull.

    Outside, trimesh would look for a way to rest for ever.
    """
    for candidate in candidates:
        with np.errstate(divide="ignore", invalid="ignore"):  # no volume
            centre: Floats = candidate.center_mass
        depths = np.einsum("fi,fi->f", hull.triangles_center - centre, hull.face_normals)
        if (depths > 0.0).all():
            return centre
    raise ValueError("the hull has no inside")


def _centre_heights(ups: Floats, corners: Floats) -> Floats:
    """Height of the centre of mass over the table for each upward direction (k, 3), resting or not."""
    heights: Floats = np.max(ups @ -corners.T, axis=1)
    return heights


def _basins(ups: Floats, heights: Floats, corners: Floats, push: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """For each pose the index of the pose that it settles into under pushes that lift the centre by `push`.

    From the lowest pose upwards, each joins the basin of the lower pose that it reaches over the lowest
    pass on the great circle, if that pass is lower than `push` above it.
    """
    home = np.arange(len(ups))
    order = np.argsort(heights, kind="stable")
    for rank, pose in enumerate(order[1:], start=1):
        lower = order[:rank]
        rises = [_pass_height(ups[pose], ups[other], corners) - heights[pose] for other in lower]
        best = int(np.argmin(rises))
        if rises[best] < push:
            home[pose] = home[lower[best]]
    return home


def _pass_height(start: Floats, end: Floats, corners: Floats) -> float:
    """The highest that the centre of mass gets while the upward direction moves from `start` to `end`."""
    angle = float(np.arccos(np.clip(start @ end, -1.0, 1.0)))
    if angle > np.pi - 1e-6:  # opposite directions have no one great circle; anything over is a real push
        return float(np.inf)
    if angle < _ARC_STEP_RAD:
        return float(_centre_heights(np.array([start, end]), corners).max())
    steps = np.linspace(0.0, 1.0, int(np.ceil(angle / _ARC_STEP_RAD)) + 1)[:, None]
    arc = np.sin((1.0 - steps) * angle) * start + np.sin(steps * angle) * end
    return float(_centre_heights(arc / np.linalg.norm(arc, axis=1, keepdims=True), corners).max())


def _resting(up: Floats, height: float, centre: Floats, probability: float) -> StablePose:
    rotation = upright_rotation(up / np.linalg.norm(up))
    x, y, z = np.array([0.0, 0.0, height]) - rotation @ centre
    w, i, j, k = quaternion_of_matrix(rotation)
    return StablePose((float(x), float(y), float(z)), (float(w), float(i), float(j), float(k)), probability)
