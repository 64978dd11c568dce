"""Grids of beams, and conversion of scans with any layout of beams to one grid.

The number of beams, the first angle and the increment of an LDS-02, LD06, LD19 or YDLIDAR differ from revolution to
revolution. A median over such revolutions, or a comparison of two of them, needs one grid for all: the grid of the
scenario's lidar, on which each beam takes the range of the nearest measured beam.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from voa_ros.messages import LaserScan

GRID_WITHIN_RAD = 1e-4
"""Largest difference of the angles of two beams, radians, that count as the same beam, as in the service."""
_MOST_SLACK = 0.05
"""Most share of an increment by which float32 rounding of angles may exceed half an increment."""
_MEASURED_WITHIN_M = 0.002
_PICOSCAN_NEAREST_M = 0.05


@dataclass(frozen=True)
class BeamGrid:
    """Directions of the beams of a lidar: beam `i` points to `angle_min + i * angle_increment`.

    Attributes:
        beams: number of beams, at least 1.
        angle_min: angle of beam 0, radians.
        angle_increment: angle from one beam to the next, radians; not 0.
    """

    beams: int
    angle_min: float
    angle_increment: float

    @property
    def span_rad(self) -> float:
        """Angle that the beams cover, radians: one increment per beam."""
        return self.beams * abs(self.angle_increment)


def grid_of(scan: LaserScan) -> BeamGrid:
    """Return the grid on which a scan was measured."""
    return BeamGrid(len(scan.ranges), scan.angle_min, scan.angle_increment)


def same_grid(one: LaserScan, other: LaserScan) -> bool:
    """True if two scans have the same number of beams, and no angle differs by more than 1e-4 rad."""
    last = len(one.ranges) - 1
    first_off = one.angle_min - other.angle_min
    last_off = first_off + last * (one.angle_increment - other.angle_increment)
    return len(one.ranges) == len(other.ranges) and max(abs(first_off), abs(last_off)) <= GRID_WITHIN_RAD


def binned(parts: Sequence[LaserScan], grid: BeamGrid) -> list[float | None]:
    """Put measured beams on a grid: each beam of the grid takes the nearest measured one within half an increment.

    Args:
        parts: one scan, or several that together are one revolution.
        grid: grid of the result; angles are compared modulo a full turn.

    Returns:
        Ranges of the `grid.beams` beams, metres, with the special values of LaserScans; None where no measured beam is
        within half an increment.
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
    """Yield the beams of a grid on both sides of an angle, with their distances, all in increments.

    An angle half way between two beams is equally near to both. The first beam is also reached from below, after a full
    turn; on a grid of a full turn whose last beam has the direction of the first, one angle meets both of them.
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
    """Join scans on a grid: stamp, frame and times of the first, the widest limits of all, and no intensities."""
    return replace(
        with_limits_of(parts),
        angle_min=grid.angle_min,
        angle_max=grid.angle_min + (grid.beams - 1) * grid.angle_increment,
        angle_increment=grid.angle_increment,
        ranges=_ranges_on_grid(parts, grid),
        intensities=(),
    )


def with_limits_of(scans: Sequence[LaserScan]) -> LaserScan:
    """Return the first scan with the widest range limits of all scans; limits (0, 0) where none states any."""
    limits = [(scan.range_min, scan.range_max) for scan in scans if scan.range_min < scan.range_max]
    near = min((low for low, _ in limits), default=0.0)
    far = max((high for _, high in limits), default=0.0)
    return replace(scans[0], range_min=near, range_max=far)


def without_measured_limits(scan: LaserScan) -> LaserScan:
    """Remove the range limits of a scan where they are those of its own ranges, and not of the sensor.

    The driver of a picoScan writes the nearest and the farthest range of each message as its limits. With these limits,
    predicted returns beyond the farthest measured range would not count.
    """
    returns = [value for value in scan.ranges if 0.0 < value < math.inf]
    if not returns:
        return replace(scan, range_min=0.0, range_max=0.0) if scan.range_min > scan.range_max else scan
    near = scan.range_min >= min(returns) - _MEASURED_WITHIN_M or scan.range_min == _PICOSCAN_NEAREST_M
    far = abs(scan.range_max - max(returns)) <= _MEASURED_WITHIN_M
    return replace(scan, range_min=0.0, range_max=0.0) if near and far else scan


def aligned(one: LaserScan, other: LaserScan, grid: BeamGrid) -> tuple[Sequence[float], Sequence[float]]:
    """Return the ranges of two scans beam by beam: unchanged where their beams are the same, else both on the grid."""
    if same_grid(one, other):
        return one.ranges, other.ranges
    return _ranges_on_grid([one], grid), _ranges_on_grid([other], grid)


def upside_down(scan: LaserScan) -> LaserScan:
    """Convert the scan of a lidar that hangs upside down to that of an upright lidar with the same direction of +x.

    A lidar that is rolled over about its +x axis counts its angles clockwise in the robot's frame: beam `i` points to
    minus its angle. The beams are listed in reverse order, so that the sign of the increment is kept.
    """
    last = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
    return replace(
        scan, angle_min=-last, angle_max=-scan.angle_min, ranges=scan.ranges[::-1], intensities=scan.intensities[::-1]
    )
