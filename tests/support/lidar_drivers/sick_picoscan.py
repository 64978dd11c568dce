"""SICK picoScan150 by sick_scan_xd's topic of segments (ros_msgpack_publisher.cpp at commit 02b3a0b).

Modelled: a revolution of 276 degrees in steps of 0.125 degree (performance profile 10, 40 Hz) comes as several
messages, each with the points, first and last angle, and stamp of its own segment; the increment is worked out from
these; ranges to 1 mm; 0 for nothing in range and for a lost beam; range_min and range_max are no limits of the sensor
but the nearest and the farthest range of the message, 1 mm further out, the nearest at least 0.05 m; scan_time is that
of the last whole revolution, 0 in the first; intensities; frame `world_1` (the launch file's frame and the layer).

A segment in which nothing answers has range_min 0.05 and range_max 0.001 m, which `LaserScan` refuses: it is left out.

Not verified: where the segments begin (an assumption: every 30 degrees from the axis, as of the multiScan, hence ten
of 18 or 30 degrees; reports say that their sizes differ), and the padding with zeros that SICK's maintainers mention.
The topic of whole revolutions is not modelled: it is one such message of all points.
"""

import math
from itertools import pairwise

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from tests.support.lidar_drivers.scene import Floats
from voa_ros.messages import LaserScan

_STEP_DEG = 0.125
_POINTS = 2209
_BOUNDS_DEG = (-138.0, -120.0, -90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0, 120.0, 138.125)
SEGMENTS = len(_BOUNDS_DEG) - 1


def _publish(turn: Turn) -> list[LaserScan]:
    degrees = _BOUNDS_DEG[0] + _STEP_DEG * np.arange(_POINTS, dtype=np.float64)
    measured = quantised(turn.measure(np.radians(degrees)), 0.001)
    ranges = np.where(np.isfinite(measured), measured, 0.0)
    scan_time = turn.period_s if turn.number else 0.0
    segments = []
    for low, high in pairwise(_BOUNDS_DEG):
        inside = (degrees >= low) & (degrees < high)
        segment = _segment(turn, degrees[inside], ranges[inside], scan_time)
        segments += [] if segment is None else [segment]
    return segments


def _segment(turn: Turn, degrees: Floats, ranges: Floats, scan_time: float) -> LaserScan | None:
    if not ranges.any():
        return None
    low, high = math.radians(degrees[0]), math.radians(degrees[-1])
    header = Header(
        stamp_s=turn.start_s + (degrees[0] + 180.0) / 360.0 * turn.period_s,
        frame_id="world_1",
        angle_min=low,
        angle_max=high,
        angle_increment=(high - low) / (len(ranges) - 1),
        time_increment=scan_time * (high - low) / (math.tau * len(ranges)),
        scan_time=scan_time,
        range_min=max(0.05, float(ranges.min()) - 0.001),
        range_max=float(ranges.max()) + 0.001,
    )
    return header.message(ranges, np.where(ranges > 0.0, 3000.0, 0.0))


PICOSCAN150 = Driver("sick-picoscan150", "sick-picoscan150", (40.0,), _publish, messages_per_turn=SEGMENTS)
