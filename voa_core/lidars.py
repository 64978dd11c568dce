"""The planar lidar: directions of its beams, range limits, meaning of a zero, noise; and where it stands."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from voa_core.checks import Floats, number
from voa_core.errors import InvalidInput

Zero = Literal["missing", "no_return"]
"""Meaning of a range of exactly 0: the driver lost the beam, or nothing came back."""

GRID_TOLERANCE_RAD = 1e-4
SMALLEST_INCREMENT_RAD = 1e-6


@dataclass(frozen=True)
class BeamGrid:
    """Directions of the beams: `angle_min + i * angle_increment`, counter-clockwise from the sensor's +x.

    A negative increment is a lidar that turns clockwise.
    """

    beams: int
    angle_min: float
    angle_increment: float

    def __post_init__(self) -> None:
        if self.beams < 1:
            raise InvalidInput("beams", "at least 1", str(self.beams))
        number("angle_min", self.angle_min)
        if number("angle_increment", self.angle_increment) == 0.0:
            raise InvalidInput("angle_increment", "a number other than 0", "0")
        if not SMALLEST_INCREMENT_RAD <= abs(self.angle_increment) <= 2.0 * np.pi:
            raise InvalidInput(
                "angle_increment",
                f"{SMALLEST_INCREMENT_RAD:g} rad to a turn, to either side",
                repr(self.angle_increment),
            )

    @property
    def angles(self) -> Floats:
        """Directions of the beams, (beams,) radians, counter-clockwise from the sensor's +x."""
        return self.angle_min + self.angle_increment * np.arange(self.beams, dtype=np.float64)

    def agrees_with(self, other: "BeamGrid") -> bool:
        """True if both grids have as many beams and no two of them differ by more than 1e-4 rad (whole turns aside)."""
        if self == other or self.beams != other.beams:
            return self == other
        apart = np.remainder(self.angles - other.angles + np.pi, 2.0 * np.pi) - np.pi
        return bool(np.abs(apart).max() <= GRID_TOLERANCE_RAD)


@dataclass(frozen=True)
class LidarModel:
    """A planar lidar.

    Attributes:
        grid: directions of the beams.
        range_min: metres; a shorter measurement counts as missing.
        range_max: metres; a longer measurement counts as a no-return.
        height_m: height of the scan plane over the table, or None where every sensor configuration has its own.
        zero: meaning of a range of 0.
        noise_m: standard deviation of a range close by, metres.
        noise_ratio: standard deviation of a long range, as a share of it; the larger of both counts.
        dropout: share of beams that come back empty from a surface in range.
    """

    grid: BeamGrid
    range_min: float
    range_max: float
    height_m: float | None
    zero: Zero
    noise_m: float
    noise_ratio: float
    dropout: float

    def __post_init__(self) -> None:
        number("range_min", self.range_min, at_least=0.0)
        number("range_max", self.range_max, above=self.range_min)
        if self.height_m is not None:
            number("height_m", self.height_m)
        if self.zero not in get_args(Zero):
            raise InvalidInput("zero", " or ".join(map(repr, get_args(Zero))), repr(self.zero))
        number("noise_m", self.noise_m, above=0.0)
        number("noise_ratio", self.noise_ratio, at_least=0.0)
        number("dropout", self.dropout, at_least=0.0, below=1.0)

    def beams_of(self, grid: BeamGrid | None) -> BeamGrid:
        """Return the beams of a scan on a grid: the lidar's own where the two agree, or where there is no other."""
        return self.grid if grid is None or self.grid.agrees_with(grid) else grid


@dataclass(frozen=True)
class SensorConfiguration:
    """A place from which the lidar can look: its own pose in the world frame, and the cost of going there.

    Attributes:
        x, y: metres.
        yaw_rad: direction of beam angle 0, counter-clockwise from the world's +x.
        height_m: height of the scan plane; None: the lidar's.
        cost: of a look from there, in success probability.
    """

    name: str
    x: float
    y: float
    yaw_rad: float
    height_m: float | None = None
    cost: float = 0.0

    def __post_init__(self) -> None:
        for field in ("x", "y", "yaw_rad"):
            number(field, getattr(self, field))
        if self.height_m is not None:
            number("height_m", self.height_m)
        number("cost", self.cost, at_least=0.0)


@dataclass(frozen=True)
class SensorUncertainty:
    """Standard deviations of an uncertain sensor pose: of each of x and y, in metres, and of the yaw, in radians."""

    xy_m: float
    yaw_rad: float

    def __post_init__(self) -> None:
        number("xy_m", self.xy_m, at_least=0.0)
        number("yaw_rad", self.yaw_rad, at_least=0.0)
