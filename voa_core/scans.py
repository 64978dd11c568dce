"""Measured scans: which beam is a return, which says that nothing is there, and which says nothing.

Inside the core a beam is one float64: its range in metres for a return, `inf` for a no-return, NaN for a
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
    """The ranges of one revolution as the driver gave them, and what it said of its own limits.

    Attributes:
        ranges: (r,) metres; NaN or -inf: missing, inf: no-return, 0: what the lidar's `zero` says.
        grid: the scan's beams.
        no_return: indices of beams that are no-returns whatever stands in `ranges`.
        range_min, range_max: metres; None: the lidar's.
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

    def limits(self, lidar: LidarModel) -> tuple[float, float]:
        """`range_min, range_max` in metres: the scan's own where it has them, else the lidar's."""
        return (
            lidar.range_min if self.range_min is None else self.range_min,
            lidar.range_max if self.range_max is None else self.range_max,
        )


def scan_of(lidar: LidarModel, ranges: Sequence[float | None], no_return: Sequence[int] = ()) -> Scan:
    """A scan on the lidar's own beams; None is a missing beam."""
    values = np.array([MISSING if value is None else value for value in ranges], dtype=np.float64)
    return Scan(values, BeamGrid(len(values), lidar.grid.angle_min, lidar.grid.angle_increment), tuple(no_return))


def classify(scan: Scan, lidar: LidarModel, crossing: Crossing | None) -> Floats:
    """Every beam of a measured scan as a return (its range), a no-return (inf) or missing (NaN).

    The order is that of deploy/docs/mathematics.md, "What each beam says". An index in `no_return` goes first: what
    stands in `ranges` there is ignored.

    Args:
        scan: as the driver gave it.
        lidar: its limits hold where the scan has none of its own.
        crossing: where the scan's beams cross the workspace; None: there is no workspace.

    Returns:
        Shape (r,).
    """
    low, high = scan.limits(lidar)
    raw = scan.ranges
    declared = np.zeros(raw.shape, dtype=bool)
    declared[list(scan.no_return)] = True
    lost = np.isnan(raw) | (raw == -np.inf)
    zero = raw == 0.0
    zero_lost = zero if lidar.zero == "missing" else np.zeros_like(zero)
    short = ~zero & (raw < low)
    nothing = declared | ((raw > high) & ~short) | (zero & ~zero_lost)
    beams = np.where(nothing, NO_RETURN, np.where(lost | zero_lost | short, MISSING, raw))
    if crossing is None:
        return beams
    returned = np.isfinite(beams)
    beams = np.where(returned & crossing.before(beams), MISSING, beams)
    return np.where(np.isfinite(beams) & ~crossing.inside(beams), NO_RETURN, beams)


def restrict_prediction(ranges: Floats, range_max: float, crossing: Crossing | None) -> Floats:
    """Predicted ranges (n, r) as they are compared: a hit beyond `range_max` or outside the workspace is none."""
    seen = ranges <= range_max
    if crossing is not None:
        seen &= crossing.inside(ranges)
    return np.where(seen, ranges, NO_RETURN)
