"""Imperfections of the simulated world as named parameters, all zero in the ideal one."""

import math
from dataclasses import dataclass
from typing import Self

from voa_fleet.errors import InvalidObject

PACKET_BEAMS = 6
"""Beams in a packet of an LDS-01: a lost packet loses them all."""


@dataclass(frozen=True)
class Clutter:
    """A box that the lidar sees; the arm passes through it.

    Attributes:
        name: of its geometry.
        centre: x, y in metres; the box stands on the floor.
        size: along its own x and y, and how high it reaches over the table's top, metres.
        yaw_rad: turned about the vertical.
    """

    name: str
    centre: tuple[float, float]
    size: tuple[float, float, float]
    yaw_rad: float = 0.0


def wall(name: str, x: float, y: float, length_m: float, yaw_rad: float = 0.0) -> Clutter:
    """Make a thin wall, half a metre higher than the table, centred at (x, y) and along x before it is turned."""
    return Clutter(name, (x, y), (length_m, 0.02, 0.5), yaw_rad)


def room(half_size_m: float) -> tuple[Clutter, ...]:
    """Make the four walls of a room around the origin, which an indoor lidar sees behind the object."""
    length = 2.0 * half_size_m + 0.02
    return (
        wall("east", half_size_m, 0.0, length, math.pi / 2.0),
        wall("north", 0.0, half_size_m, length),
        wall("west", -half_size_m, 0.0, length, math.pi / 2.0),
        wall("south", 0.0, -half_size_m, length),
    )


@dataclass(frozen=True)
class Imperfections:
    """Errors of the simulated world; standard deviations are those of independent normal errors.

    Attributes:
        robot_xy_m: standard deviation of the robot's position in x and in y; it believes to be where it was sent.
        robot_yaw_rad: standard deviation of the robot's heading.
        range_noise_m: standard deviation of a measured range.
        range_noise_ratio: standard deviation of a range beyond `near_m` as a share of the range, where that is more.
        near_m: range from which a lidar's data sheet states the noise as a share.
        beam_loss: share of beams that hit a surface and give no return.
        packet_loss: share of packets of six beams that get lost.
        resolution_m: step of the measured ranges; 0: no rounding.
        object_xy_m: standard deviation of the object's position about its pose, in x and in y.
        object_yaw_rad: standard deviation of the object's heading about its pose.
        clutter: boxes and walls beside the object.
    """

    robot_xy_m: float = 0.0
    robot_yaw_rad: float = 0.0
    range_noise_m: float = 0.0
    range_noise_ratio: float = 0.0
    near_m: float = 0.5
    beam_loss: float = 0.0
    packet_loss: float = 0.0
    resolution_m: float = 0.0
    object_xy_m: float = 0.0
    object_yaw_rad: float = 0.0
    clutter: tuple[Clutter, ...] = ()

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, float) and not (math.isfinite(value) and value >= 0.0):
                raise InvalidObject(f"{name}: expected a number of at least 0, got {value}")
        for name in ("beam_loss", "packet_loss"):
            if getattr(self, name) > 1.0:
                raise InvalidObject(f"{name}: expected a share of at most 1, got {getattr(self, name)}")

    @classmethod
    def of_lds_01(cls) -> Self:
        """Return the errors of an LDS-01 lidar in a room with walls 2 m to each side.

        Noise: the paper measured 1 to 3 mm at 30 to 40 cm, so 3 mm below half a metre; beyond, the 3 % of the
        data sheet. Ranges are whole millimetres. That a packet in fifty and a beam in fifty get lost is an assumption.
        """
        return cls(
            range_noise_m=0.003,
            range_noise_ratio=0.03,
            beam_loss=0.02,
            packet_loss=0.02,
            resolution_m=0.001,
            clutter=room(2.0),
        )
