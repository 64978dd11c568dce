"""Measured scans, and the classification of their beams as return, no-return or missing.

In classified scans a beam is one float64: its range in metres for a return, `inf` for a no-return, NaN for a
missing beam. Predicted beams are never missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.lidars import BeamGrid, LidarModel
from voa_core.workspace import Crossing

NO_RETURN = np.inf
MISSING = np.nan


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan of one revolution, as the driver of the lidar gave it.

    Attributes:
        ranges: (r,) metres; NaN or -inf: missing, inf: no-return, 0: as the lidar's `zero` says.
        grid: the scan's beams.
        no_return: indices of beams that are no-returns, regardless of their entry in `ranges`.
        range_min, range_max: limits between which ranges are trusted, metres; None: the lidar's.

    Raises:
        InvalidInput: the shape, an index or a limit is wrong.
    """

    ranges: Floats
    grid: BeamGrid
    no_return: tuple[int, ...] = ()
    range_min: float | None = None
    range_max: float | None = None

    def __post_init__(self) -> None:
        if self.ranges.shape != (self.grid.beams,):
            raise InvalidInput("ranges", f"{self.grid.beams} beams", f"shape {self.ranges.shape}")
        wrong = [index for index in self.no_return if not 0 <= index < self.grid.beams]
        if wrong:
            raise InvalidInput("no_return", f"indices from 0 to {self.grid.beams - 1}", str(wrong[0]))
        for field in ("range_min", "range_max"):
            value = getattr(self, field)
            if value is not None and not (np.isfinite(value) and value >= 0.0):
                raise InvalidInput(field, "a finite number of at least 0", repr(value))
        if self.range_min is not None and self.range_max is not None and self.range_min > self.range_max:
            raise InvalidInput("range_max", f"at least range_min ({self.range_min})", repr(self.range_max))

    @classmethod
    def recorded(cls, ranges: Floats, lidar: LidarModel) -> "Scan":
        """Make a scan on the lidar's beams from recorded ranges (r,), which count however short they are.

        The recording has judged them already: the lidar's `range_min`, below which a measurement is missing, does not
        apply; raises InvalidInput for another shape.
        """
        return cls(ranges, lidar.grid, range_min=0.0)

    def limits(self, lidar: LidarModel) -> tuple[float, float]:
        """Limits `range_min, range_max` in metres: the scan's own where it has them, else the lidar's."""
        return (
            lidar.range_min if self.range_min is None else self.range_min,
            lidar.range_max if self.range_max is None else self.range_max,
        )


def scan_of(lidar: LidarModel, ranges: Sequence[float | None], no_return: Sequence[int] = ()) -> Scan:
    """Make a scan on the lidar's own beams from ranges in metres, None for a missing beam; raises InvalidInput."""
    values = np.array([MISSING if value is None else value for value in ranges], dtype=np.float64)
    return Scan(values, BeamGrid(len(values), lidar.grid.angle_min, lidar.grid.angle_increment), tuple(no_return))


def classify(scan: Scan, lidar: LidarModel, crossing: Crossing | None) -> Floats:
    """Classify every beam of a measured scan as a return (its range), a no-return (inf) or missing (NaN).

    An index in `no_return` takes precedence over the range; then come lost beams, zeros and the range limits. At last,
    with a workspace, a return before it is missing and a return behind it is a no-return.

    Args:
        scan: as measured.
        lidar: its limits apply where the scan has none of its own.
        crossing: distances at which the scan's beams cross the workspace; None: there is no workspace.

    Returns:
        Shape (r,).
    """
    low, high = scan.limits(lidar)
    raw = scan.ranges
    beams = np.where(raw > high, NO_RETURN, raw)
    np.putmask(beams, raw < low, MISSING)  # -inf among them
    np.putmask(beams, raw == 0.0, MISSING if lidar.zero == "missing" else NO_RETURN)
    if scan.no_return:
        beams[list(scan.no_return)] = NO_RETURN
    if crossing is None:
        return beams
    returned = np.isfinite(beams)
    beams = np.where(returned & crossing.before(beams), MISSING, beams)
    return np.where(np.isfinite(beams) & ~crossing.inside(beams), NO_RETURN, beams)


def restrict_prediction(ranges: Floats, range_max: float, crossing: Crossing | None) -> Floats:
    """Limit predicted ranges (n, r) to `range_max` and the workspace: a hit beyond becomes a no-return."""
    seen = ranges <= range_max
    if crossing is not None:
        seen &= crossing.inside(ranges)
    return np.where(seen, ranges, NO_RETURN)
