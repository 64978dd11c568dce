"""Grids of beams, and scans of any layout brought onto one.

The number of beams, the first angle and the increment of an LDS-02, LD06, LD19 or YDLIDAR differ from revolution to
revolution. A median over such revolutions, or a comparison of two of them, needs one grid for all: that of the
scenario's lidar, on which each of its beams takes the measured beam nearest to it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from voa_ros.messages import LaserScan

GRID_WITHIN_RAD = 1e-4
"""Beams that differ by no more are the same beams, as in the service's contract."""
_MOST_SLACK = 0.05
"""Of an increment, at most: what the float32s of angles may add to half an increment."""
_MEASURED_WITHIN_M = 0.002
_PICOSCAN_NEAREST_M = 0.05


@dataclass(frozen=True)
class BeamGrid:
    """Directions of the beams of a lidar: beam `i` points to `angle_min + i * angle_increment`.

    Attributes:
        beams: how many, at least 1.
        angle_min: of beam 0, radians.
        angle_increment: radians from one beam to the next; not 0.
    """

    beams: int
    angle_min: float
    angle_increment: float

    @property
    def span_rad(self) -> float:
        """Angle that the beams cover, each with one increment of its own."""
        return self.beams * abs(self.angle_increment)


def grid_of(scan: LaserScan) -> BeamGrid:
    """The grid that a scan was measured on."""
    return BeamGrid(len(scan.ranges), scan.angle_min, scan.angle_increment)


def same_grid(one: LaserScan, other: LaserScan) -> bool:
    """Whether two scans have the same beams: as many, and none turned by more than 1e-4 rad."""
    last = len(one.ranges) - 1
    first_off = one.angle_min - other.angle_min
    last_off = first_off + last * (one.angle_increment - other.angle_increment)
    return len(one.ranges) == len(other.ranges) and max(abs(first_off), abs(last_off)) <= GRID_WITHIN_RAD


def binned(parts: Sequence[LaserScan], grid: BeamGrid) -> list[float | None]:
    """Measured beams on a grid: each beam of the grid takes the nearest measured one within half an increment.

    Args:
        parts: one scan, or several that together are one revolution.
        grid: the grid; angles are compared modulo a full turn.

    Returns:
        `grid.beams` ranges as the LaserScans have them; None where no measured beam is within half an increment.
    """
    ranges: list[float | None] = [None] * grid.beams
    distances = [0.5 + min(GRID_WITHIN_RAD / abs(grid.angle_increment), _MOST_SLACK)] * grid.beams
    turn = math.tau / abs(grid.angle_increment)
    for part in parts:
        step = part.angle_increment / grid.angle_increment
        first = (part.angle_min - grid.angle_min) / grid.angle_increment
        for index, value in enumerate(part.ranges):
            for beam, distance in _nearby((first + index * step) % turn, turn, grid.beams):
                if distance < distances[beam]:
                    ranges[beam], distances[beam] = value, distance
    return ranges


def _ranges_on_grid(parts: Sequence[LaserScan], grid: BeamGrid) -> tuple[float, ...]:
    return tuple(math.nan if value is None else value for value in binned(parts, grid))


def _nearby(place: float, turn: float, beams: int) -> Iterator[tuple[int, float]]:
    """Beams of a grid on both sides of a place, and how far they are, in increments.

    A place half way between two beams is as near to one as to the other. The first beam is also reached from below, a
    turn on; a grid of a whole turn whose last beam points where the first does has beams at two places.
    """
    low = math.floor(place)
    for beam in (low, low + 1):
        if beam < beams:
            yield beam, abs(place - beam)
    if place > turn - 1.0:
        yield 0, turn - place
    if place + turn < beams:
        low = math.floor(place + turn)
        for beam in range(low, min(low + 2, beams)):
            yield beam, abs(place + turn - beam)


def on_grid(parts: Sequence[LaserScan], grid: BeamGrid) -> LaserScan:
    """One scan on a grid, with stamp, frame and times of the first of its parts, the limits of all, no intensities."""
    return replace(
        with_limits_of(parts),
        angle_min=grid.angle_min,
        angle_max=grid.angle_min + (grid.beams - 1) * grid.angle_increment,
        angle_increment=grid.angle_increment,
        ranges=_ranges_on_grid(parts, grid),
        intensities=(),
    )


def with_limits_of(scans: Sequence[LaserScan]) -> LaserScan:
    """The first of some scans, with the widest limits of all; (0, 0) where none of them states any."""
    limits = [(scan.range_min, scan.range_max) for scan in scans if scan.range_min < scan.range_max]
    near = min((low for low, _ in limits), default=0.0)
    far = max((high for _, high in limits), default=0.0)
    return replace(scans[0], range_min=near, range_max=far)


def without_measured_limits(scan: LaserScan) -> LaserScan:
    """The scan without its limits where they are those of its own ranges, and not the sensor's.

    The driver of a picoScan writes the nearest and the farthest range of each message as its limits. Nothing that
    another pose of the object would show beyond the farthest could then be expected.
    """
    returns = [value for value in scan.ranges if 0.0 < value < math.inf]
    if not returns:
        return replace(scan, range_min=0.0, range_max=0.0) if scan.range_min > scan.range_max else scan
    near = scan.range_min >= min(returns) - _MEASURED_WITHIN_M or scan.range_min == _PICOSCAN_NEAREST_M
    far = abs(scan.range_max - max(returns)) <= _MEASURED_WITHIN_M
    return replace(scan, range_min=0.0, range_max=0.0) if near and far else scan


def aligned(one: LaserScan, other: LaserScan, grid: BeamGrid) -> tuple[Sequence[float], Sequence[float]]:
    """Ranges of two scans, beam by beam: as they are where their beams are the same, else both on the grid."""
    if same_grid(one, other):
        return one.ranges, other.ranges
    return _ranges_on_grid([one], grid), _ranges_on_grid([other], grid)


def upside_down(scan: LaserScan) -> LaserScan:
    """The scan of a lidar that hangs upside down, as if it stood upright with its +x in the same direction.

    A lidar that is rolled over about its +x axis counts its angles clockwise in the robot's frame: beam `i` points to
    minus its angle. The beams are listed in reverse, so that the sign of the increment stays.
    """
    last = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
    return replace(
        scan, angle_min=-last, angle_max=-scan.angle_min, ranges=scan.ranges[::-1], intensities=scan.intensities[::-1]
    )
