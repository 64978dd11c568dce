"""SICK TiM571 by sick_scan_xd (sick_lmd_scandata_parser.cpp at commit 1536fbb, sick_tim_5xx.launch at 04eb4d0).

Modelled: 811 beams from -135 degrees in steps of 0.3333 degree, as the telegrams give them, always the same; ranges to
1 mm; limits 0 and 100 m, which the launch file sets; times of 15 Hz and 16.2 kHz, as the telegrams give them;
intensities; frame `cloud`; the stamp is that of the begin of the measurement (by the driver's software clock). A range
of 0, for nothing in range and for a beam that was lost, stays 0, which lies within the limits of the message.

Not verified: that no later step of the driver replaces a 0 (the older driver sick_tim publishes it as +inf).
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from voa_ros.messages import LaserScan

_BEAMS = 811


def _publish(turn: Turn) -> list[LaserScan]:
    low, step = math.radians(-135.0), math.radians(0.3333)
    ranges = quantised(turn.measure(low + step * np.arange(_BEAMS)), 0.001)
    given = np.isfinite(ranges)
    header = Header(
        stamp_s=turn.start_s,
        frame_id="cloud",
        angle_min=low,
        angle_max=low + (_BEAMS - 1) * step,
        angle_increment=step,
        time_increment=1.0 / 16200.0,
        scan_time=1.0 / 15.0,
        range_min=0.0,
        range_max=100.0,
    )
    return [header.message(np.where(given, ranges, 0.0), np.where(given, 120.0, 0.0))]


TIM571 = Driver("sick-tim571", "sick-tim571", (15.0,), _publish)
