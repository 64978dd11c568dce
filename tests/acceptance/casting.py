"""Ray casting of planar cuts, written from the definition: the nearest crossing of a ray with the segments of a cut."""

import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_EDGE = 1e-9


def turned(angle: float | Floats) -> Floats:
    """Rotation matrices in the plane, (..., 2, 2), of angles in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)


def matrix_of(quaternion: tuple[float, float, float, float]) -> Floats:
    """Rotation matrix (3, 3) of a quaternion w, x, y, z."""
    w, x, y, z = quaternion
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix: Floats = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    return matrix


def cut(mesh: trimesh.Trimesh, rotation: Floats, z: float, height: float) -> Floats:
    """Cut a mesh that is turned by `rotation` and raised by `z` by the plane z = `height`.

    Returns:
        Segments (k, 2, 2): x and y of both ends, metres, relative to the position of the pose.
    """
    vertices = mesh.vertices @ rotation.T + np.array([0.0, 0.0, z])
    corners = vertices[mesh.faces]  # (f, 3, 3)
    above = corners[:, :, 2] > height
    crossed = corners[above.any(axis=1) & ~above.all(axis=1)]
    ends = []
    for one, other in ((0, 1), (1, 2), (2, 0)):
        low, high = crossed[:, one], crossed[:, other]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (height - low[:, 2]) / (high[:, 2] - low[:, 2])
            crossing = low[:, :2] + share[:, None] * (high - low)[:, :2]
        met = (low[:, 2] > height) != (high[:, 2] > height)
        ends.append(np.where(met[:, None], crossing, np.nan))
    points = np.stack(ends, axis=1)  # of three edges, exactly two cross the plane
    segments: Floats = points[np.isfinite(points[:, :, 0])].reshape(-1, 2, 2)
    return segments


def cast(segments: Floats, origins: Floats, angles: Floats) -> Floats:
    """Range at which each ray first meets a segment.

    Args:
        segments: (k, 2, 2) metres.
        origins: (N, 2) metres; all rays of a scan begin at its origin.
        angles: (N, r) directions of the rays, radians.

    Returns:
        Shape (N, r), metres; inf where a ray meets none.
    """
    ranges = np.full(angles.shape, np.inf)
    if len(segments) == 0:
        return ranges
    near, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    at_once = max(1, 2**20 // (angles.shape[1] * len(segments)))
    for start in range(0, len(origins), at_once):
        block = slice(start, start + at_once)
        x, y = np.cos(angles[block])[:, :, None], np.sin(angles[block])[:, :, None]
        away = near - origins[block][:, None, :]
        away_x, away_y = away[:, None, :, 0], away[:, None, :, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            across = x * along[:, 1] - y * along[:, 0]
            distance = (away_x * along[:, 1] - away_y * along[:, 0]) / across
            share = (away_x * y - away_y * x) / across
            met = (distance > 0.0) & (share >= -_EDGE) & (share <= 1.0 + _EDGE)
        ranges[block] = np.where(met, distance, np.inf).min(axis=2)
    return ranges


def window(segments: Floats, origins: Floats, headings: Floats, beams: Floats) -> NDArray[np.intp]:
    """Indices of the beams (angles (r,), radians) that may meet the segments from one of the origins (N, 2)."""
    if len(segments) == 0:
        return np.zeros(0, dtype=np.intp)
    centre = segments.reshape(-1, 2).mean(axis=0)
    reach = float(np.hypot(*(segments.reshape(-1, 2) - centre).T).max())
    away = centre - origins
    distance = np.hypot(*away.T)
    half = np.where(distance > reach, np.arcsin(np.minimum(1.0, reach / np.maximum(distance, 1e-9))), np.pi) + 1e-3
    bearing = np.arctan2(away[:, 1], away[:, 0]) - headings
    off = np.abs(np.remainder(beams - bearing[:, None] + np.pi, 2.0 * np.pi) - np.pi)
    return np.flatnonzero((off <= half[:, None]).any(axis=0))


def box(low: tuple[float, float], high: tuple[float, float]) -> Floats:
    """Segments (4, 2, 2) of a rectangle that is parallel to the axes."""
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
