"""Join the segments of a revolution, which some lidars publish one by one.

A picoScan150 publishes each revolution in segments of about 30 degrees. Two successive scans that cover much less than
the scenario's lidar, and different angles, are recognised as segments. Segments are kept until they cover the whole
revolution, or until one covers the same angles again, which starts the next revolution.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from voa_ros.grids import BeamGrid, grid_of, on_grid
from voa_ros.messages import LaserScan

PARTIAL_SHARE = 0.7
"""Share of the lidar's angles; a scan that covers less may be a segment."""
MOST_SEGMENTS = 256
"""Most segments of one revolution."""
LONGEST_TURN_S = 2.0
"""Longest time between two segments of one revolution, seconds."""
_DISJOINT = 0.1
"""Share of common angles below which two scans are different segments."""
_AGAIN = 0.5
"""Share of common angles above which two scans cover the same angles."""

M = TypeVar("M")


@dataclass(frozen=True)
class JoinedScan(Generic[M]):
    """Scan of a whole revolution.

    Attributes:
        scan: all beams of the revolution.
        message: message that brought the last segment.
    """

    scan: LaserScan
    message: M


@dataclass(frozen=True)
class _Segment(Generic[M]):
    scan: LaserScan
    message: M
    received_s: float


class SegmentJoiner(Generic[M]):
    """Joiner of the segments of revolutions; scans that cover a whole revolution pass unchanged."""

    def __init__(self, grid: BeamGrid) -> None:
        """Start with no segment.

        Args:
            grid: grid of the scenario's lidar, on which the segments are joined.
        """
        self._grid = grid
        self._before: LaserScan | None = None
        self._segments: list[_Segment[M]] = []
        self._in_segments = False
        """True if the previous scan was a segment."""

    @property
    def segments(self) -> int:
        """Number of segments of the revolution that is not complete yet."""
        return len(self._segments)

    def receive(self, scan: LaserScan, message: M, received_s: float) -> JoinedScan[M] | None:
        """Add the next scan; returns the scan of a whole revolution if it is complete now, else None.

        The very first segment is returned as if it were a revolution, because only the next one shows that it was a
        segment. A lidar that always covers the same few angles has no segments.

        Args:
            scan: a segment or a whole revolution.
            message: message that brought the scan; it is returned with the revolution.
            received_s: time of arrival, seconds by any steady clock.
        """
        before, self._before = self._before, scan
        self._in_segments = before is not None and self._is_segment(scan, before)
        if not self._in_segments:
            self._segments.clear()
            return JoinedScan(scan, message)
        segment = _Segment(scan, message, received_s)
        if self._segments and received_s - self._segments[-1].received_s > LONGEST_TURN_S:
            self._segments.clear()
        if any(_overlap(scan, other.scan) > _AGAIN for other in self._segments) or self.segments >= MOST_SEGMENTS:
            revolution = self._joined()
            self._segments = [segment]
            return revolution
        self._segments.append(segment)
        covered = sum(_shared_rad(grid_of(other.scan), self._grid) for other in self._segments)
        if covered < self._grid.span_rad - 1.5 * abs(self._grid.angle_increment):
            return None
        revolution = self._joined()
        self._segments = []
        return revolution

    def _is_segment(self, scan: LaserScan, before: LaserScan) -> bool:
        partial = _shared_rad(grid_of(scan), self._grid) < PARTIAL_SHARE * self._grid.span_rad
        return partial and _overlap(scan, before) < (_AGAIN if self._in_segments else _DISJOINT)

    def _joined(self) -> JoinedScan[M]:
        scans = [segment.scan for segment in self._segments]
        whole = scans[0]
        if len(scans) > 1:
            whole = replace(on_grid(scans, self._grid), scan_time=_duration_s(scans))
        return JoinedScan(whole, self._segments[-1].message)


def _duration_s(segments: Sequence[LaserScan]) -> float:
    """Seconds from the first ray of the first segment to the last ray of the last; implausible stamps are not used."""
    first, last = segments[0], segments[-1]
    seconds = last.stamp.seconds - first.stamp.seconds + (last.scan_time if math.isfinite(last.scan_time) else 0.0)
    return seconds if 0.0 < seconds <= LONGEST_TURN_S else first.scan_time


def _overlap(one: LaserScan, other: LaserScan) -> float:
    """Share of the smaller of two spans of angles that both scans cover, modulo a full turn."""
    first, second = grid_of(one), grid_of(other)
    return _shared_rad(first, second) / min(first.span_rad, second.span_rad)


def _shared_rad(one: BeamGrid, other: BeamGrid) -> float:
    """Angle that two grids both cover, radians, modulo a full turn."""
    apart = math.remainder(_middle(one) - _middle(other), math.tau)
    half, whole = min(one.span_rad, math.tau) / 2.0, min(other.span_rad, math.tau) / 2.0
    return sum(
        max(0.0, min(apart + turned + half, whole) - max(apart + turned - half, -whole))
        for turned in (-math.tau, 0.0, math.tau)
    )


def _middle(grid: BeamGrid) -> float:
    return grid.angle_min + (grid.beams - 1) * grid.angle_increment / 2.0
