"""Cutting the object at each pose by the lidar's plane: what a planar lidar can see of a mesh.

A pose needs its own cut only if it tilts or lifts the object differently: poses that differ by a planar
motion share one, up to a rigid transform in the plane.

The mesh is a closed set: where vertices lie exactly on the plane, the object touches it, and a beam in the
plane sees what it touches. So such a plane is cut twice, as if it lay a hair below and a hair above, and both
contours count. Each of the two treats every vertex as strictly on one side, which keeps contours closed:
no segment is lost or doubled at a vertex.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.errors import NoMesh
from voa_core.geometry import upright_rotation
from voa_core.jit import kernel
from voa_core.objects import Object
from voa_core.poses import PoseSet

ON_PLANE_M = 1e-10
_SAME_TILT = 1e-12

Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Contours:
    """The cuts of all poses by one plane.

    Attributes:
        points: (q, 2) float64, metres, each cut in its own planar frame.
        segments: (g, 2) int32, indices of points within their cut.
        point_start, segment_start: (cuts + 1,) offsets of each cut into `points` and `segments`.
        cut_of_pose: (n,) which cut a pose shares.
        placement: (n, 4) cos, sin, x, y: from the cut's planar frame to the world.
    """

    points: Floats
    segments: Ints
    point_start: NDArray[np.int64]
    segment_start: NDArray[np.int64]
    cut_of_pose: NDArray[np.int64]
    placement: Floats

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.points.nbytes + self.segments.nbytes + self.placement.nbytes + self.cut_of_pose.nbytes


def cut_poses(object_: Object, poses: PoseSet, height_m: float) -> Contours:
    """Cut the object at every pose by the plane z = `height_m`.

    Raises:
        NoMesh: the poses have no geometry.
    """
    if poses.rotations is None or poses.positions is None:
        raise NoMesh("the poses have names only; predictions from the mesh need position and quaternion_wxyz")
    ups = poses.rotations[:, 2, :]
    levels = poses.positions[:, 2] - height_m
    keys = np.round(np.column_stack([ups, levels]) / _SAME_TILT)
    _, first, cut_of_pose = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    cut_of_pose = cut_of_pose.reshape(-1)
    frames = [upright_rotation(ups[index]) for index in first]
    points, segments = zip(
        *(_cut(object_, frame, float(levels[i])) for frame, i in zip(frames, first, strict=True)), strict=True
    )
    turned = np.einsum("nij,nkj->nik", poses.rotations, np.stack(frames)[cut_of_pose])
    placement = np.column_stack([turned[:, 0, 0], turned[:, 1, 0], poses.positions[:, :2]])
    return Contours(
        np.concatenate(points),
        np.concatenate(segments),
        _offsets(points),
        _offsets(segments),
        cut_of_pose.astype(np.int64),
        np.ascontiguousarray(placement),
    )


def _offsets(pieces: tuple[NDArray[np.generic], ...]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum([len(piece) for piece in pieces])]).astype(np.int64)


def _cut(object_: Object, frame: Floats, level: float) -> tuple[Floats, Ints]:
    """Points (q, 2) and segments (g, 2) of one cut, in the planar frame of `frame`'s first two rows."""
    turned = object_.vertices @ frame.T
    heights = turned[:, 2] + level
    on_plane = np.abs(heights) <= ON_PLANE_M
    heights[on_plane] = 0.0
    planar = np.ascontiguousarray(turned[:, :2])
    ends, sides = object_.edges
    points, segments = _cut_faces(heights, heights >= 0.0, planar, ends, sides)
    if on_plane.any():
        more, again = _cut_faces(heights, heights > 0.0, planar, ends, sides)
        points, segments = np.concatenate([points, more]), np.concatenate([segments, again + len(points)])
    return points, segments


@kernel
def _cut_faces(
    heights: Floats, above: NDArray[np.bool_], planar: Floats, ends: Ints, sides: Ints
) -> tuple[Floats, Ints]:
    """Segments of the faces whose corners lie on both sides; one point per cut edge, shared by its two faces."""
    point_of_edge = np.full(len(ends), -1, dtype=np.int32)
    crossed = np.zeros(len(ends), dtype=np.bool_)
    n_points = 0
    for e in range(len(ends)):
        if above[ends[e, 0]] != above[ends[e, 1]]:
            crossed[e] = True
            n_points += 1
    points = np.zeros((n_points, 2))
    n_points = 0
    n_segments = 0
    for f in range(len(sides)):
        if crossed[sides[f, 0]] or crossed[sides[f, 1]] or crossed[sides[f, 2]]:
            n_segments += 1
    segments = np.zeros((n_segments, 2), dtype=np.int32)
    n_segments = 0
    for f in range(len(sides)):
        found = 0
        for k in range(3):
            e = sides[f, k]
            if not crossed[e]:
                continue
            if point_of_edge[e] < 0:
                low, high = ends[e, 0], ends[e, 1]
                share = heights[low] / (heights[low] - heights[high])
                for axis in range(2):
                    points[n_points, axis] = planar[low, axis] + share * (planar[high, axis] - planar[low, axis])
                point_of_edge[e] = n_points
                n_points += 1
            if found < 2:
                segments[n_segments, found] = point_of_edge[e]
            found += 1
        if found > 0:
            n_segments += 1
    return points, segments
