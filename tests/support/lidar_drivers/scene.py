"""A planar world of segments, and exact distances in it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Box = tuple[float, float, float, float, float]
"""Centre x and y, length and width in metres, yaw in radians."""


def _outline(box: Box) -> list[tuple[float, float, float, float]]:
    x, y, length, width, yaw = box
    c, s = math.cos(yaw), math.sin(yaw)
    halves = [(length / 2, width / 2), (-length / 2, width / 2), (-length / 2, -width / 2), (length / 2, -width / 2)]
    corners = [(x + c * u - s * v, y + s * u + c * v) for u, v in halves]
    return [(*one, *other) for one, other in zip(corners, [*corners[1:], corners[0]], strict=True)]


@dataclass(frozen=True, eq=False)
class Scene:
    """Walls and outlines of objects in the plane of the lidar.

    Attributes:
        segments: (s, 4) metres, from x, y to x, y; may be empty.
    """

    segments: Floats

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> "Scene":
        """Build a world of outlines alone; beams that meet none go on for ever."""
        lines = [line for box in boxes for line in _outline(box)]
        return cls(np.array(lines, dtype=np.float64).reshape(-1, 4))

    @classmethod
    def room(cls, half_width_m: float, boxes: Sequence[Box] = ()) -> "Scene":
        """Build a square room about the origin with boxes in it."""
        return cls.of([(0.0, 0.0, 2.0 * half_width_m, 2.0 * half_width_m, 0.0), *boxes])

    def distances(self, x: ArrayLike, y: ArrayLike, yaw: float, angles: ArrayLike) -> Floats:
        """Measure along rays without noise.

        Args:
            x, y: where the rays begin in the world, metres; one place, or one for each ray.
            yaw: radians; where the sensor's +x points to.
            angles: (r,) radians, counter-clockwise from the sensor's +x.

        Returns:
            (r,) metres to the nearest segment; inf where there is none.
        """
        heading = yaw + np.asarray(angles, dtype=np.float64)[:, None]
        ux, uy = np.cos(heading), np.sin(heading)
        px = np.broadcast_to(np.asarray(x, dtype=np.float64).reshape(-1, 1), heading.shape)
        py = np.broadcast_to(np.asarray(y, dtype=np.float64).reshape(-1, 1), heading.shape)
        ax, ay, bx, by = self.segments.T
        ex, ey = bx - ax, by - ay
        across = ux * ey - uy * ex
        with np.errstate(divide="ignore", invalid="ignore"):
            along = ((ax - px) * ey - (ay - py) * ex) / across
            share = ((ax - px) * uy - (ay - py) * ux) / across
        hit = (np.abs(across) > 1e-12) & (along > 0.0) & (share >= -1e-12) & (share <= 1.0 + 1e-12)
        return np.asarray(np.where(hit, along, np.inf).min(axis=1, initial=np.inf))
