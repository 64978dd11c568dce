"""How an object can rest on the table, and how probable each way is.

The raw proposals are those of `trimesh.poses.compute_stable_poses` (quasi-static, Goldberg et al., "Part pose
statistics", 1999): one per facet of the convex hull that the object can rest on. A curved side is many
facets, yet the object rolls over their edges at a breath: the physically distinct ways to rest are the
basins of the height of the centre of mass that need a real push to leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.geometry import quaternion_of_matrix, upright_rotation
from voa_core.objects import Object

if TYPE_CHECKING:
    import trimesh

_PUSH = 0.01  # of the object's size: a centre of mass that must rise by less does not hold the object


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
    import trimesh  # noqa: PLC0415 - a second of everybody's start-up, needed for this alone

    mesh = trimesh.Trimesh(object_.vertices, object_.faces, process=False)
    try:
        hull = mesh.convex_hull
        centre = _centre_of_mass([mesh, hull] if object_.watertight else [hull], hull)
        transforms, probabilities = trimesh.poses.compute_stable_poses(hull, center_mass=centre, seed=0)
        ups = np.array(transforms)[:, 2, :3]
    except Exception as error:  # scipy's Qhull raises several kinds
        raise InvalidInput("object", "a mesh with a volume", "one without a convex hull") from error
    heights = np.einsum("fi,fi->f", hull.triangles_center - centre, hull.face_normals)
    home = _basins(hull, centre, heights, _PUSH * float(np.linalg.norm(hull.extents)))
    settled = home[np.argmax(ups @ -hull.face_normals.T, axis=1)]
    total = float(np.sum(probabilities))
    poses = [
        _resting(-hull.face_normals[face], heights[face], centre, float(np.sum(probabilities[settled == face])) / total)
        for face in np.unique(settled)
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


def _basins(
    hull: trimesh.Trimesh, centre: Floats, heights: Floats, push: float
) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """For each face of the hull the face that it settles on under pushes that lift the centre by less than `push`.

    The height of the centre of mass over the table is a landscape over the upward directions; its passes lead over
    the hull's edges. From the lowest pass upwards, the shallower of the two basins that meet there joins the deeper
    if its bottom is less than `push` below the pass.
    """
    home = list(range(len(heights)))

    def bottom(face: int) -> int:
        while home[face] != face:
            home[face] = home[home[face]]
            face = home[face]
        return face

    passes = _pass_heights(hull, centre, heights)
    for edge in np.argsort(passes, kind="stable"):
        low, high = sorted((bottom(int(face)) for face in hull.face_adjacency[edge]), key=lambda face: heights[face])
        if passes[edge] - heights[high] < push:
            home[high] = low
    return np.array([bottom(face) for face in home])


def _pass_heights(hull: trimesh.Trimesh, centre: Floats, heights: Floats) -> Floats:
    """The highest that the centre of mass gets while the hull tips over each edge, from face to face.

    It moves on a circle about the edge; its top is the edge's distance, if that lies between the two faces.
    """
    start, end = (hull.vertices[hull.face_adjacency_edges[:, k]] - centre for k in range(2))
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    arm = start - np.einsum("ei,ei->e", start, along)[:, None] * along
    first, second = (hull.face_normals[hull.face_adjacency[:, k]] for k in range(2))
    between = np.einsum("ei,ei->e", np.cross(first, arm), np.cross(first, second)) > 0.0
    between &= np.einsum("ei,ei->e", np.cross(second, arm), np.cross(second, first)) > 0.0
    ends: Floats = heights[hull.face_adjacency].max(axis=1)
    return np.where(between, np.linalg.norm(arm, axis=1), ends)


def _resting(up: Floats, height: float, centre: Floats, probability: float) -> StablePose:
    rotation = upright_rotation(up / np.linalg.norm(up))
    x, y, z = np.array([0.0, 0.0, height]) - rotation @ centre
    w, i, j, k = quaternion_of_matrix(rotation)
    return StablePose((float(x), float(y), float(z)), (float(w), float(i), float(j), float(k)), probability)
