"""Whole revolutions out of the segments that some lidars send.

A picoScan150 publishes each revolution in segments of some 30 degrees. One segment is no look: where two scans in a row
cover much less than the scenario's lidar, and other angles, they are segments. These are kept until they complete the
turn, or until one comes that covers the same angles again, which begins the next turn.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from voa_ros.grids import BeamGrid, on_grid
from voa_ros.messages import LaserScan

PARTIAL_SHARE = 0.7
"""A scan that covers less of the lidar's angles than this share may be a segment of a turn."""
MOST_SEGMENTS = 256
_DISJOINT = 0.1
"""Scans that share less of their angles are different segments."""
_AGAIN = 0.5
"""Scans that share more of their angles cover the same ones."""
_LONGEST_TURN_S = 2.0


class TurnGatherer:
    """Joins the segments of a turn; scans that cover the whole turn pass at once."""

    def __init__(self, grid: BeamGrid) -> None:
        """Begin with no segment.

        Args:
            grid: of the scenario's lidar, on which the segments are joined.
        """
        self._grid = grid
        self._before: LaserScan | None = None
        self._segments: list[LaserScan] = []

    @property
    def segments(self) -> int:
        """Segments of the turn that is not complete yet."""
        return len(self._segments)

    def receive(self, scan: LaserScan) -> LaserScan | None:
        """Take the next scan; returns a whole turn where there is one now, else None.

        The very first segment is passed on as if it were a turn: only the next one shows that it was a segment. A lidar
        that always covers the same few angles has no segments.
        """
        before, self._before = self._before, scan
        if before is None or not self._is_segment(scan, before):
            self._segments.clear()
            return scan
        if any(_overlap(scan, other) > _AGAIN for other in self._segments) or self.segments >= MOST_SEGMENTS:
            turn = self._joined()
            self._segments = [scan]
            return turn
        self._segments.append(scan)
        if sum(map(_span, self._segments)) < self._grid.span_rad - 1.5 * abs(self._grid.angle_increment):
            return None
        turn = self._joined()
        self._segments = []
        return turn

    def _is_segment(self, scan: LaserScan, before: LaserScan) -> bool:
        partial = _span(scan) < PARTIAL_SHARE * self._grid.span_rad
        return partial and _overlap(scan, before) < (_AGAIN if self._segments else _DISJOINT)

    def _joined(self) -> LaserScan:
        if len(self._segments) == 1:
            return self._segments[0]
        return replace(on_grid(self._segments, self._grid), scan_time=_duration_s(self._segments))


def _duration_s(segments: Sequence[LaserScan]) -> float:
    """Seconds from the first ray of the first segment to the last ray of the last; as the first says if stamps lie."""
    first, last = segments[0], segments[-1]
    seconds = last.stamp.seconds - first.stamp.seconds + (last.scan_time if math.isfinite(last.scan_time) else 0.0)
    return seconds if 0.0 < seconds <= _LONGEST_TURN_S else first.scan_time


def _span(scan: LaserScan) -> float:
    return len(scan.ranges) * abs(scan.angle_increment)


def _overlap(one: LaserScan, other: LaserScan) -> float:
    """Share of the smaller of two spans that both cover, modulo a full turn."""
    smaller = min(_span(one), _span(other))
    apart = abs(math.remainder(_middle(one) - _middle(other), math.tau))
    return max(0.0, min(smaller, (_span(one) + _span(other)) / 2.0 - apart)) / smaller


def _middle(scan: LaserScan) -> float:
    return scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment / 2.0
