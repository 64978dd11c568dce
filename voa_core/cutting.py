"""Cuts of the object by the plane of the lidar, at each pose: the part of a mesh that a planar lidar can see.

Poses that differ by a motion in the plane share a cut, up to that motion. Only a pose that tilts or lifts the object
differently needs a cut of its own.

The mesh is a closed set: where vertices lie exactly on the plane, the object touches it, and a beam in the
plane sees what it touches. Such a plane is cut twice, as if it lay slightly below and slightly above, and both
contours count. Each of the two treats every vertex as strictly on one side, which keeps contours closed:
no segment is lost or doubled at a vertex.

A plane meets few faces. Neighbouring faces share a box, and those in a box that the plane misses are passed over.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from voa_core.chains import Chains, chains_of
from voa_core.checks import Floats
from voa_core.errors import NoMesh
from voa_core.geometry import upright_rotation
from voa_core.jit import kernel
from voa_core.objects import Object
from voa_core.outlines import Ints, Outlines, outlines_of
from voa_core.poses import PoseSet

ON_PLANE_M = 1e-10
_SAME_TILT = 1e-12


@dataclass(frozen=True, eq=False)
class Contours:
    """The cuts of all poses by one plane.

    Attributes:
        points: (q, 2) float64, metres, each cut in its own planar frame.
        segments: (g, 2) int32, indices of points within their cut.
        point_start, segment_start: (cuts + 1,) offsets of each cut into `points` and `segments`.
        cut_of_pose: (n,) index of the cut that shows each pose.
        placement: (n, 4) cos, sin, x, y of each pose: the motion from the planar frame of its cut to the world.
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
        own = self.points.nbytes + self.segments.nbytes + self.placement.nbytes + self.cut_of_pose.nbytes
        # The outlines and the chains are made when they are needed.
        return own + 3 * self.points.nbytes + 2 * self.segments.nbytes

    @cached_property
    def outlines(self) -> Outlines:
        """Outlines of the cuts, for predictions of many displaced copies."""
        return outlines_of(self.points, self.segments, self.point_start, self.segment_start)

    @cached_property
    def chains(self) -> Chains:
        """Chains of the points of the cuts, for predictions of poses."""
        return chains_of(self.points, self.segments, self.point_start, self.segment_start)


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
    frames = upright_rotation(ups[first])
    points, segments, point_start, segment_start = _cut_each(
        object_.vertices,
        object_.faces,
        object_.edges[1],
        *object_.boxes,
        frames,
        levels[first],
    )
    turned = np.einsum("nij,nj->ni", poses.rotations, frames[cut_of_pose, 0])
    placement = np.column_stack([turned[:, :2], poses.positions[:, :2]])
    return Contours(points, segments, point_start, segment_start, cut_of_pose.astype(np.int64), placement)


@kernel
def _cut_each(
    vertices: Floats,
    faces: Ints,
    sides: Ints,
    boxed: Ints,
    centres: Floats,
    halves: Floats,
    frames: Floats,
    levels: Floats,
) -> tuple[Floats, Ints, NDArray[np.int64], NDArray[np.int64]]:
    """Cut the object once for each frame: `points`, `segments`, `point_start` and `segment_start` of Contours.

    Args:
        vertices: (v, 3).
        faces: (f, 3) vertices of each face.
        sides: (f, 3) edges of each face, the first between its first two corners.
        boxed, centres, halves: of `Object.boxes`.
        frames: (k, 3, 3) rotations of the object into the frame of each cut; the last row is the plane's normal.
        levels: (k,) height over the plane of the object's origin.
    """
    points, segments = np.zeros((64, 2)), np.zeros((64, 2), dtype=np.int32)
    point_start = np.zeros(len(levels) + 1, dtype=np.int64)
    segment_start = np.zeros(len(levels) + 1, dtype=np.int64)
    heights = np.zeros(len(vertices))
    point_of_edge = np.full(sides.max() + 1, -1, dtype=np.int32)
    for cut in range(len(levels)):
        frame = frames[cut]
        met, touched = _meet(vertices, faces, boxed, centres, halves, frame[2], levels[cut], heights)
        p, s = point_start[cut], segment_start[cut]
        for hair in range(2 if touched else 1):
            more, joined = _contour(vertices, faces, sides, met, heights, hair == 0, frame, point_of_edge)
            points, segments = _with_room(points, p + len(more)), _with_room(segments, s + len(joined))
            points[p : p + len(more)] = more
            segments[s : s + len(joined)] = joined + np.int32(p - point_start[cut])
            p += len(more)
            s += len(joined)
        point_start[cut + 1], segment_start[cut + 1] = p, s
    return points[: point_start[-1]].copy(), segments[: segment_start[-1]].copy(), point_start, segment_start


@kernel
def _with_room(rows: NDArray[Any], needed: int) -> NDArray[Any]:
    """Give `rows` (q, 2) room for at least `needed` rows: itself, or a larger copy."""
    if needed <= len(rows):
        return rows
    larger = np.zeros((2 * needed, 2), dtype=rows.dtype)
    larger[: len(rows)] = rows
    return larger


@kernel
def _meet(
    vertices: Floats,
    faces: Ints,
    boxed: Ints,
    centres: Floats,
    halves: Floats,
    up: Floats,
    level: float,
    heights: Floats,
) -> tuple[Ints, bool]:
    """Find the faces that the plane meets, and if it touches a vertex; writes the `heights` of their corners."""
    gaps = np.zeros(centres.shape[1])
    for box in range(len(gaps)):
        above = up[0] * centres[0, box] + up[1] * centres[1, box] + up[2] * centres[2, box] + level
        reach = abs(up[0]) * halves[0, box] + abs(up[1]) * halves[1, box] + abs(up[2]) * halves[2, box]
        gaps[box] = abs(above) - reach
    near = boxed[gaps <= 2.0 * ON_PLANE_M]
    met = np.zeros(near.size, dtype=np.int32)
    count = 0
    touched = False
    for group in near:
        for f in group:
            if f < 0:
                break
            lowest, highest = np.inf, -np.inf
            for corner in range(3):
                vertex = faces[f, corner]
                x, y, z = vertices[vertex, 0], vertices[vertex, 1], vertices[vertex, 2]
                height = up[0] * x + up[1] * y + up[2] * z + level
                if abs(height) <= ON_PLANE_M:
                    height = 0.0
                    touched = True
                heights[vertex] = height
                lowest, highest = min(lowest, height), max(highest, height)
            if lowest <= 0.0 <= highest:
                met[count] = f
                count += 1
    return met[:count], touched


@kernel
def _contour(
    vertices: Floats,
    faces: Ints,
    sides: Ints,
    met: Ints,
    heights: Floats,
    touching_is_above: bool,
    frame: Floats,
    point_of_edge: Ints,
) -> tuple[Floats, Ints]:
    """Segments of the faces whose corners lie on both sides; one point per cut edge, shared by its two faces.

    `point_of_edge` is scratch space: -1 everywhere before and after the call.
    """
    points, edges = np.zeros((2 * len(met), 2)), np.zeros(2 * len(met), dtype=np.int32)
    segments = np.zeros((len(met), 2), dtype=np.int32)
    n_points = 0
    n_segments = 0
    for f in met:
        ends = 0
        for k in range(3):
            low, high = faces[f, k], faces[f, (k + 1) % 3]
            if _is_above(heights[low], touching_is_above) == _is_above(heights[high], touching_is_above):
                continue
            e = sides[f, k]
            if point_of_edge[e] < 0:
                low, high = min(low, high), max(low, high)  # both faces compute the same
                share = heights[low] / (heights[low] - heights[high])
                for axis in range(2):
                    start = _along(frame[axis], vertices[low])
                    points[n_points, axis] = start + share * (_along(frame[axis], vertices[high]) - start)
                point_of_edge[e] = n_points
                edges[n_points] = e
                n_points += 1
            segments[n_segments, ends] = point_of_edge[e]
            ends += 1
        if ends > 0:
            n_segments += 1
    point_of_edge[edges[:n_points]] = -1
    return points[:n_points], segments[:n_segments]


@kernel
def _is_above(height: float, touching_is_above: bool) -> bool:
    return height > 0.0 or (touching_is_above and height == 0.0)


@kernel
def _along(axis: Floats, vertex: Floats) -> float:
    return float(axis[0] * vertex[0] + axis[1] * vertex[1] + axis[2] * vertex[2])
