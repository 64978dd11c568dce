"""Stable poses: the ways in which an object can rest on the table, and the probability of each.

An object touches the table with its convex hull, whose rests `toppling` computes. This module finds the centre of mass,
and the pose of the object's frame in each rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.geometry import quaternion_of_matrix, upright_rotation
from voa_core.objects import Object
from voa_core.toppling import Body, Rest, rests
from voa_core.winding import outward_faces

MOST_POINTS = 200_000
MOST_HULL_FACES = 50_000
_THINNEST = 1e-8  # of the size of the object: a thinner one has no volume to rest on


@dataclass(frozen=True)
class StablePose:
    """A pose in which the object rests on the table, z = 0, with the probability that a dropped object ends so.

    Attributes:
        position: (x, y, z) of the object's frame in the world, metres; the centre of mass lies over x = y = 0.
        quaternion_wxyz: orientation of the object's frame in the world, w first.
        probability: of this rest after a drop in a random orientation.
    """

    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, float, float, float]
    probability: float


def propose_stable_poses(object_: Object) -> list[StablePose]:
    """Propose the stable poses of an object, most probable first; the probabilities sum to 1.

    A rest that topples at less than 9 degrees of tilt in its weakest direction is merged into the rest that it falls
    to, and the facets of a curved wall into one; every other is listed, however improbable.

    Args:
        object_: a mesh of uniform density. If it is not watertight, or has only one side, the centre of mass is that of
            its convex hull. The origin of its frame may lie far from it.

    Raises:
        InvalidInput: the mesh has no volume to rest on (flat, or fewer than four points), more than 200 000 points,
            or a convex hull of more than 50 000 triangles.
    """
    origin = object_.vertices[np.unique(object_.faces)].mean(axis=0)
    body, centre = _about_centre_of_mass(object_, origin)
    poses = [_resting(rest, centre, origin) for rest in rests(body)]
    return sorted(poses, key=lambda pose: -pose.probability)


def _about_centre_of_mass(object_: Object, origin: Floats) -> tuple[Body, Floats]:
    """Compute the convex hull with the centre of mass at its origin, and that centre relative to `origin`."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415 - slow to import, and needed for this alone

    points = object_.vertices[np.unique(object_.faces)] - origin
    size = float(np.ptp(points, axis=0).max())
    _at_most("points", MOST_POINTS, len(points))
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise _no_volume() from error
    _at_most("triangles in its convex hull", MOST_HULL_FACES, len(hull.simplices))
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    for centre in _centres_of_mass(object_, origin, points[hull.simplices]):
        distances = -(normals @ centre + offsets)
        if distances.min() > _THINNEST * size:  # False for NaN, of a mesh without volume
            triangles, neighbours = (each.astype(np.intp) for each in (hull.simplices, hull.neighbors))
            return Body(points - centre, triangles, neighbours, normals, distances), centre
    raise _no_volume()


def _centres_of_mass(object_: Object, origin: Floats, hull: Floats) -> list[Floats]:
    """Centres of mass to try: the mesh's, if it encloses a volume, then that of its hull of triangles (t, 3, 3)."""
    centres = []
    faces = outward_faces(object_)
    if faces is not None:
        corners = object_.vertices[faces] - origin
        centres.append(_centroid(corners, _volumes(corners)))
    about = hull.reshape(-1, 3).mean(axis=0)
    centres.append(about + _centroid(hull - about, np.abs(_volumes(hull - about))))
    return centres


def _volumes(corners: Floats) -> Floats:
    """Volumes of the tetrahedra from the origin to triangles (f, 3, 3), times six, (f,)."""
    volumes: Floats = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return volumes


def _centroid(corners: Floats, volumes: Floats) -> Floats:
    """Centroid of the tetrahedra from the origin to triangles (f, 3, 3) with signed volumes; NaN or inf without one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        centroid: Floats = volumes @ corners.sum(axis=1) / (4.0 * volumes.sum())
    return centroid


def _at_most(what: str, most: int, count: int) -> None:
    if count > most:
        raise InvalidInput("object", f"a mesh of at most {most} {what}, to rest on the table", f"{count}: simplify it")


def _no_volume() -> InvalidInput:
    return InvalidInput("object", "a mesh with a volume", "one without a convex hull: it is flat, or a line")


def _resting(rest: Rest, centre: Floats, origin: Floats) -> StablePose:
    up = -rest.down
    rotation = upright_rotation(up / np.linalg.norm(up))
    x, y, z = np.array([0.0, 0.0, rest.height]) - rotation @ centre - rotation @ origin
    w, i, j, k = quaternion_of_matrix(rotation)
    return StablePose((float(x), float(y), float(z)), (float(w), float(i), float(j), float(k)), rest.probability)
