"""LDS-02 (LD08) of a TurtleBot3 since 2022 by ROBOTIS' ld08_driver 1.1 (read at commit 0867129).

Modelled: 2 300 samples a second on a clock of their own, clockwise, angles to 0.01 degree and ranges to 1 mm; the
sensor's triangulation, whose rays begin 21 mm beside the axis and leave at a slant, moved to the axis point by point,
so that the directions are not evenly spaced; the sensor's zeros are dropped; the first angle is that of the first
point, the increment is whole degrees a second by 2 300, and the beams are as many as fit; a beam with no point is
NaN, one with two has the nearer; limits 0 and 100 m; frame `base_scan`; the stamp is set after the revolution.

Not modelled: the filter of weak points nearer than 1 m, and the delay of up to 10 ms of the publishing loop.
Not verified: how fast a real motor wanders (an assumption: 0.3 %).
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn
from tests.support.lidar_drivers.scene import Floats
from voa_ros.messages import LaserScan

RATE_HZ = 2300.0
_OFFSET_M = (0.0059, -0.02014)
_SLANT = 0.11923


def _points(turn: Turn) -> tuple[Floats, Floats]:
    """Directions in degrees, counter-clockwise in [0, 360), and ranges in metres of a revolution, as sampled."""
    head = math.tau - np.radians(np.round(np.degrees(turn.phases(RATE_HZ)), 2))
    c, s = np.cos(head), np.sin(head)
    forward, left = c * _OFFSET_M[0] - s * _OFFSET_M[1], s * _OFFSET_M[0] + c * _OFFSET_M[1]
    along = turn.measure(head + math.atan(_SLANT), forward, left)
    raw = np.round(1000.0 * along / math.hypot(1.0, _SLANT)) / 1000.0
    kept = np.isfinite(raw)
    x, y = raw[kept] + _OFFSET_M[0], raw[kept] * _SLANT + _OFFSET_M[1]
    return np.degrees(head[kept] + np.arctan2(y, x)) % 360.0, np.hypot(x, y)


def _publish(turn: Turn) -> list[LaserScan]:
    speed = round(360.0 * turn.hz)
    degrees, ranges = _points(turn)
    if not len(degrees):
        return []
    low, high = math.radians(degrees.min()), math.radians(degrees.max())
    increment = math.radians(speed / RATE_HZ)
    beams = math.ceil((high - low) / increment)
    beam_ranges = np.full(beams, np.nan)
    index = np.floor((np.radians(degrees) - low) / increment).astype(int)
    inside = (index >= 0) & (index < beams)
    np.fmin.at(beam_ranges, index[inside], ranges[inside])
    header = Header(
        stamp_s=turn.start_s + turn.period_s,
        frame_id="base_scan",
        angle_min=low,
        angle_max=high,
        angle_increment=increment,
        time_increment=(360.0 / speed) / ((high - low) / increment),
        scan_time=360.0 / speed,
        range_min=0.0,
        range_max=100.0,
    )
    return [header.message(beam_ranges, np.where(np.isnan(beam_ranges), np.nan, 200.0))]


LDS_02 = Driver("lds-02", "lds-02", (5.0, 10.0), _publish, reach_increments=1.0, wandering=0.003)
