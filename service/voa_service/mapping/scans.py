"""Raw scans: from messages to the mathematics."""

from collections.abc import Sequence

import numpy as np

from voa_core.errors import BeamGridMismatch, InvalidInput
from voa_core.lidars import BeamGrid, LidarModel
from voa_core.scans import MISSING, Scan
from voa_msgs import sessions
from voa_msgs.base import Range

_FULL_TURN = 2.0 * np.pi


def scan_of(scan: sessions.Scan, lidar: LidarModel) -> Scan:
    """Build a scan from its message; the lidar supplies the beam angles and range limits that the message omits.

    Raises:
        BeamGridMismatch: the number of ranges differs from the lidar's number of beams while the scan states no angles
            of its own; or the beams span more than a full turn.
        InvalidInput: the range limits contradict each other.
    """
    grid = _grid(scan, lidar.grid)
    ranges = np.array(floats(scan.ranges, MISSING))
    result = Scan(ranges, grid, tuple(scan.no_return), scan.range_min, scan.range_max)
    low, high = result.limits(lidar)
    if low > high:
        raise InvalidInput("range_min", f"at most range_max ({high}, the scan's or the lidar's)", repr(low))
    return result


def floats(ranges: Sequence[Range], null: float) -> list[float]:
    """Return ranges in metres with `null` in the place of each None."""
    return [null if value is None else value for value in ranges]


def _grid(scan: sessions.Scan, own: BeamGrid) -> BeamGrid:
    if len(scan.ranges) != own.beams and (scan.angle_min is None or scan.angle_increment is None):
        raise BeamGridMismatch(
            f"expected one range for each of the lidar's beams ({own.beams} from {own.angle_min:g} rad by "
            f"{own.angle_increment:g} rad), got {len(scan.ranges)} ranges: a scan with other beams must say both "
            "angle_min and angle_increment"
        )
    grid = own
    if scan.angle_min is not None or scan.angle_increment is not None:
        grid = BeamGrid(
            len(scan.ranges),
            own.angle_min if scan.angle_min is None else scan.angle_min,
            own.angle_increment if scan.angle_increment is None else scan.angle_increment,
        )
    if grid.beams * abs(grid.angle_increment) > _FULL_TURN + 1.5 * abs(grid.angle_increment):
        turns = grid.beams * abs(grid.angle_increment) / _FULL_TURN
        raise BeamGridMismatch(
            f"expected the {grid.beams} beams to span at most one turn, got an angle_increment of "
            f"{grid.angle_increment:g} rad, which makes {turns:.3g} turns: is it in degrees?"
        )
    return grid
