"""Planar poses of one frame in another: composition, inverse and comparison."""

import math
from dataclasses import dataclass
from typing import Protocol


class Planar(Protocol):
    """Protocol of a pose in the plane of the floor."""

    @property
    def x(self) -> float:
        """X coordinate, metres."""

    @property
    def y(self) -> float:
        """Y coordinate, metres."""

    @property
    def yaw_rad(self) -> float:
        """Yaw, radians, counter-clockwise."""


@dataclass(frozen=True)
class Motion:
    """Pose of a frame in another frame: x and y in metres, yaw in radians."""

    x: float
    y: float
    yaw_rad: float


def wrapped(angle_rad: float) -> float:
    """Wrap an angle to [-pi, pi] radians."""
    return math.remainder(angle_rad, math.tau)


def composed(frame: Planar, inside: Planar) -> Motion:
    """Compose two poses: that of a frame in the outer frame, and one that is given inside that frame."""
    cos, sin = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    return Motion(
        x=frame.x + cos * inside.x - sin * inside.y,
        y=frame.y + sin * inside.x + cos * inside.y,
        yaw_rad=wrapped(frame.yaw_rad + inside.yaw_rad),
    )


def inverse(pose: Planar) -> Motion:
    """Invert a pose: return the pose of the outer frame in the inner one."""
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return Motion(x=-cos * pose.x - sin * pose.y, y=sin * pose.x - cos * pose.y, yaw_rad=wrapped(-pose.yaw_rad))


def within(one: Planar, other: Planar, xy_m: float, yaw_rad: float) -> bool:
    """True if two poses differ by at most `xy_m` metres and `yaw_rad` radians."""
    near = math.hypot(one.x - other.x, one.y - other.y) <= xy_m
    return near and abs(wrapped(one.yaw_rad - other.yaw_rad)) <= yaw_rad
