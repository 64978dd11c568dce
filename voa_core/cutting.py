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
_LEAST_TIMES, _MOST_TIMES = 1.2, 16.0  # room that is made beyond what is needed now
_FILLED = 0.7


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
    boxed, centres, halves = object_.boxes
    points, segments, point_start, segment_start = _cut_each(
        boxed >= 0, centres, halves, *object_.boxed_faces, frames, levels[first]
    )
    turned = np.einsum("nij,nj->ni", poses.rotations, frames[cut_of_pose, 0])
    placement = np.column_stack([turned[:, :2], poses.positions[:, :2]])
    return Contours(points, segments, point_start, segment_start, cut_of_pose.astype(np.int64), placement)


@kernel
def _cut_each(
    is_face: NDArray[np.bool_],
    centres: Floats,
    halves: Floats,
    corners: Floats,
    sides: Ints,
    frames: Floats,
    levels: Floats,
) -> tuple[Floats, Ints, NDArray[np.int64], NDArray[np.int64]]:
    """Cut the object once for each frame: `points`, `segments`, `point_start` and `segment_start` of Contours.

    Args:
        is_face: (b, 16) False where a box has fewer faces.
        centres, halves: of `Object.boxes`.
        corners, sides: of `Object.boxed_faces`.
        frames: (k, 3, 3) rotations of the object into the frame of each cut; the last row is the plane's normal.
        levels: (k,) height over the plane of the object's origin.
    """
    points, segments = np.zeros((64, 2)), np.zeros((64, 2), dtype=np.int32)
    point_start = np.zeros(len(levels) + 1, dtype=np.int64)
    segment_start = np.zeros(len(levels) + 1, dtype=np.int64)
    point_of_edge = np.full(sides.max() + 1, -1, dtype=np.int32)
    for cut in range(len(levels)):
        met = _meet(is_face, centres, halves, corners, frames[cut, 2], levels[cut])
        edges = np.zeros(2 * len(met) + 1, dtype=np.int32)
        p, s = point_start[cut], segment_start[cut]
        left = len(levels) / (cut + 1.0)
        for touching_is_above in (True, False):
            points, segments = _with_room(points, p + len(edges), left), _with_room(segments, s + len(met), left)
            more, joined, touched = _contour(
                corners,
                sides,
                met,
                frames[cut],
                levels[cut],
                touching_is_above,
                point_of_edge,
                edges,
                points[p:],
                segments[s:],
            )
            segments[s : s + joined] += np.int32(p - point_start[cut])
            p += more
            s += joined
            if not touched:
                break
        point_start[cut + 1], segment_start[cut + 1] = p, s
    return _fitted(points, point_start[-1]), _fitted(segments, segment_start[-1]), point_start, segment_start


@kernel
def _with_room(rows: NDArray[Any], needed: int, times: float) -> NDArray[Any]:
    """Give `rows` (q, 2) room for at least `needed` rows: itself, or a copy with room for up to `times` as many."""
    if needed <= len(rows):
        return rows
    larger = np.zeros((int(needed * max(min(times, _MOST_TIMES), _LEAST_TIMES)), 2), dtype=rows.dtype)
    larger[: len(rows)] = rows
    return larger


@kernel
def _fitted(rows: NDArray[Any], count: int) -> NDArray[Any]:
    """The first rows: a copy where they are far fewer than there is memory for."""
    return rows[:count] if count > _FILLED * len(rows) else rows[:count].copy()


@kernel
def _meet(
    is_face: NDArray[np.bool_], centres: Floats, halves: Floats, corners: Floats, up: Floats, level: float
) -> Ints:
    """Find the faces that the plane meets: (met, 2) the box of each, and its place in the box."""
    gaps = np.zeros(len(is_face))
    for box in range(len(gaps)):
        above = up[0] * centres[0, box] + up[1] * centres[1, box] + up[2] * centres[2, box] + level
        reach = abs(up[0]) * halves[0, box] + abs(up[1]) * halves[1, box] + abs(up[2]) * halves[2, box]
        gaps[box] = abs(above) - reach
    near = np.flatnonzero(gaps <= 2.0 * ON_PLANE_M)
    is_met = np.zeros(is_face.shape[1], dtype=np.bool_)
    met = np.zeros((near.size * is_met.size + 1, 2), dtype=np.int32)  # with room for an entry that does not count
    count = 0
    for group in near:
        _cross(corners[group], up, level, is_met)
        for lane in range(len(is_met)):  # without a branch, which a processor could not predict
            met[count, 0], met[count, 1] = group, lane
            count += int(is_met[lane] & is_face[group, lane])
    return met[:count]


@kernel
def _cross(corners: Floats, up: Floats, level: float, is_met: NDArray[np.bool_]) -> None:
    """Flag the faces of one box that have corners (3, 3, 16) on both sides of the plane, or on it."""
    for lane in range(len(is_met)):
        a = up[0] * corners[0, 0, lane] + up[1] * corners[0, 1, lane] + up[2] * corners[0, 2, lane] + level
        b = up[0] * corners[1, 0, lane] + up[1] * corners[1, 1, lane] + up[2] * corners[1, 2, lane] + level
        c = up[0] * corners[2, 0, lane] + up[1] * corners[2, 1, lane] + up[2] * corners[2, 2, lane] + level
        is_met[lane] = (min(a, b, c) <= ON_PLANE_M) & (max(a, b, c) >= -ON_PLANE_M)


@kernel
def _contour(
    corners: Floats,
    sides: Ints,
    met: Ints,
    frame: Floats,
    level: float,
    touching_is_above: bool,
    point_of_edge: Ints,
    edges: Ints,
    points: Floats,
    segments: Ints,
) -> tuple[int, int, bool]:
    """Write the segments of the faces whose corners lie on both sides; one point per cut edge, shared by its two faces.

    `point_of_edge` is -1 everywhere before and after the call, and `edges` is scratch space.

    Returns:
        The number of points, and of segments; and True if a corner of a face lies on the plane.
    """
    n_points, n_segments = 0, 0
    touched = False
    for entry in range(len(met)):
        box, lane = met[entry, 0], met[entry, 1]
        face = corners[box]
        a = _height(face, 0, lane, frame, level)
        b = _height(face, 1, lane, frame, level)
        c = _height(face, 2, lane, frame, level)
        touched |= (a == 0.0) | (b == 0.0) | (c == 0.0)
        above_a, above_b = _is_above(a, touching_is_above), _is_above(b, touching_is_above)
        above_c = _is_above(c, touching_is_above)
        if above_a == above_b == above_c:
            continue
        # Two sides are cut. Which ones, and which of their points are new, no processor could predict.
        for end in range(2):
            side = (2 if above_c != above_a else 1) if end else (0 if above_a != above_b else 1)
            edge = sides[box, side, lane]
            known = point_of_edge[edge]
            point = n_points if known < 0 else known
            point_of_edge[edge], edges[n_points] = point, edge
            segments[n_segments, end] = point
            after = 0 if side == 2 else side + 1
            from_height = a if side == 0 else (b if side == 1 else c)
            to_height = a if after == 0 else (b if after == 1 else c)
            share = from_height / (from_height - to_height)
            for axis in range(2):
                start = _along(face, side, lane, frame, axis)
                points[n_points, axis] = start + share * (_along(face, after, lane, frame, axis) - start)
            n_points += known < 0
        n_segments += 1
    point_of_edge[edges[:n_points]] = -1
    return n_points, n_segments, touched


@kernel
def _height(face: Floats, corner: int, lane: int, frame: Floats, level: float) -> float:
    """Height of a corner over the plane; exactly 0 where it lies on it to rounding."""
    height = _along(face, corner, lane, frame, 2) + level
    return 0.0 if abs(height) <= ON_PLANE_M else height


@kernel
def _is_above(height: float, touching_is_above: bool) -> bool:
    return (height > 0.0) | (touching_is_above & (height == 0.0))


@kernel
def _along(face: Floats, corner: int, lane: int, frame: Floats, axis: int) -> float:
    return float(
        frame[axis, 0] * face[corner, 0, lane]
        + frame[axis, 1] * face[corner, 1, lane]
        + frame[axis, 2] * face[corner, 2, lane]
    )
