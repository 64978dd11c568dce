"""Proposals for the lidar's pose: each cluster of returns that is as large as the object may be the object.

If it is, the distance and the direction of the object are known, and only the side from which it is seen is not. The
pose of the lidar is written in polar coordinates about the object: the bearing of the lidar from the object, its
distance, and how far the lidar is turned away from facing it.
"""

import math

import numpy as np

from voa_setup.calibration.planar import Floats, wrapped
from voa_setup.calibration.stops import Measured

_SPLIT_M = 0.06
_LARGER = 1.3
_SLACK_M = 0.03
_FEWEST_BEAMS = 2
_BEARINGS = 120


def lidar_poses(polar: Floats, centre: Floats) -> Floats:
    """Convert polar coordinates (k, 3), bearing, distance and turn, to poses (k, 3) of the lidar in the world.

    Args:
        polar: bearing of the lidar from the object (rad), distance (m), and yaw less that of facing the object (rad).
        centre: (2,) of the object, metres.
    """
    bearing, distance, turn = polar.T
    x = centre[0] + distance * np.cos(bearing)
    y = centre[1] + distance * np.sin(bearing)
    return np.column_stack([x, y, wrapped(bearing + math.pi + turn)])


def clusters(measured: Measured) -> list[tuple[float, float]]:
    """List the clusters of neighbouring returns that are not larger than the object.

    Returns:
        Direction in the lidar's frame (rad) and nearest range (m) of each, the nearest first.
    """
    grid, ranges = measured.grid, measured.ranges
    finite = np.isfinite(ranges)
    known = np.where(finite, ranges, 0.0)
    breaks = ~finite | ~np.roll(finite, 1) | (np.abs(known - np.roll(known, 1)) > _SPLIT_M)
    if not breaks.any():
        return []
    whole_turn = grid.beams * abs(grid.angle_increment) > 2.0 * math.pi - 1.5 * abs(grid.angle_increment)
    first = int(np.flatnonzero(breaks)[0]) if whole_turn else 0
    order = np.roll(np.arange(grid.beams), -first)
    starts = np.flatnonzero(breaks[order])
    most_m = 2.0 * _LARGER * measured.target.radius_m + _SLACK_M
    result = []
    for beams in np.split(order, starts[starts > 0]):
        own = beams[finite[beams]]
        if len(own) < _FEWEST_BEAMS:
            continue
        points = ranges[own, None] * np.column_stack([np.cos(grid.angles[own]), np.sin(grid.angles[own])])
        if np.linalg.norm(points.max(axis=0) - points.min(axis=0)) <= most_m:
            middle = points.mean(axis=0)
            result.append((math.atan2(middle[1], middle[0]), float(ranges[own].min())))
    return sorted(result, key=lambda cluster: cluster[1])


def proposals(measured: Measured) -> Floats:
    """Propose poses of the lidar, in polar coordinates (k, 3): every cluster, from every side of the object."""
    radius = measured.target.radius_m
    bearings = np.linspace(-math.pi, math.pi, _BEARINGS, endpoint=False)
    rows = [
        np.column_stack([bearings, np.full(_BEARINGS, near + depth * radius), np.full(_BEARINGS, -direction)])
        for direction, near in clusters(measured)
        for depth in (0.4, 0.7, 1.0)
    ]
    return np.concatenate(rows) if rows else np.zeros((0, 3))
