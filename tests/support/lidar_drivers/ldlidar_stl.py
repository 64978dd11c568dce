"""LD19 (also LD06 and STL-19P) by LDROBOT's ldlidar_stl_ros2 (src/demo.cpp at commit 1a7ab48).

Modelled: 4 500 samples a second on a clock of their own, clockwise, ranges to 1 mm; every message covers 0 to 2 pi,
both included, with as many beams as the revolution had points, so that count and increment vary; a point goes to the
beam above its clockwise angle, which is then counted backwards; a beam with no point is NaN, one with two has the
nearer; a point without a range and without an intensity is NaN; limits 0.02 and 25 m; frame `base_laser`; the stamp is
set after the revolution.

Not modelled: the filter of weak points nearer than 5 m (it ends in NaN too), and revolutions that are skipped because
the publishing loop runs at 10 Hz. Not verified: how fast a real motor wanders (an assumption: 0.5 %, public reports
have 451 to 460 points at 10 Hz), and what the sensor sends where nothing is in range (taken to be 0 and 0).
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from voa_ros.messages import LaserScan

RATE_HZ = 4500.0


def _publish(turn: Turn) -> list[LaserScan]:
    clockwise = turn.phases(RATE_HZ)
    ranges = quantised(turn.measure(-clockwise), 0.001)
    given = np.isfinite(ranges)
    beams = len(clockwise)
    increment = math.tau / (beams - 1)
    index = np.ceil(clockwise / increment).astype(int)
    inside = given & (index < beams)
    beam_ranges = np.full(beams, np.nan)
    np.fmin.at(beam_ranges, beams - 1 - index[inside], ranges[inside])
    header = Header(
        stamp_s=turn.start_s + turn.period_s,
        frame_id="base_laser",
        angle_min=0.0,
        angle_max=math.tau,
        angle_increment=increment,
        time_increment=turn.period_s / (beams - 1),
        scan_time=turn.period_s,
        range_min=0.02,
        range_max=25.0,
    )
    return [header.message(beam_ranges, np.where(np.isnan(beam_ranges), np.nan, 200.0))]


LD19 = Driver("ld19", "ld19", (5.0, 10.0), _publish, reach_increments=1.0, wandering=0.005)
