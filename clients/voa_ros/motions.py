"""Planar motions: where one frame is in another, put one after the other and turned round."""

import math
from dataclasses import dataclass
from typing import Protocol


class Planar(Protocol):
    """Anything that says where it is on the floor."""

    @property
    def x(self) -> float:
        """Metres."""

    @property
    def y(self) -> float:
        """Metres."""

    @property
    def yaw_rad(self) -> float:
        """Counter-clockwise."""


@dataclass(frozen=True)
class Motion:
    """A frame in another: metres and radians."""

    x: float
    y: float
    yaw_rad: float


def wrapped(angle_rad: float) -> float:
    """Direction of an angle, in [-pi, pi]."""
    return math.remainder(angle_rad, math.tau)


def composed(frame: Planar, inside: Planar) -> Motion:
    """The pose of what is at `inside` in a frame, where the frame is at `frame`."""
    cos, sin = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    return Motion(
        x=frame.x + cos * inside.x - sin * inside.y,
        y=frame.y + sin * inside.x + cos * inside.y,
        yaw_rad=wrapped(frame.yaw_rad + inside.yaw_rad),
    )


def inverse(pose: Planar) -> Motion:
    """The pose of the outer frame in the inner one."""
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return Motion(x=-cos * pose.x - sin * pose.y, y=sin * pose.x - cos * pose.y, yaw_rad=wrapped(-pose.yaw_rad))


def within(one: Planar, other: Planar, xy_m: float, yaw_rad: float) -> bool:
    """Whether two poses are no farther apart than so many metres, and turned by no more than so many radians."""
    near = math.hypot(one.x - other.x, one.y - other.y) <= xy_m
    return near and abs(wrapped(one.yaw_rad - other.yaw_rad)) <= yaw_rad
