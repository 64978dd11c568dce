"""LDS-01 (HLS-LFCD2) of the first TurtleBot3 by ROBOTIS' hls_lfcd_lds_driver (main, 2025-06).

Modelled: 360 beams from 0 in steps of 1 degree, always the same; limits 0.12 to 3.5 m; the frame `base_scan` of the
TurtleBot3 launch files; 0 for nothing in range and for a lost beam, never NaN or inf; whole millimetres; times from
whole revolutions a minute; the stamp is set after the revolution.

Not modelled: lost packets of 6 beams (`lost_packets` makes them), and that the beams are measured from the last to
the first.
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from voa_ros.messages import LaserScan

_BEAMS = 360


def _publish(turn: Turn) -> list[LaserScan]:
    step = math.tau / _BEAMS
    ranges = quantised(turn.measure(step * np.arange(_BEAMS)), 0.001)
    given = np.isfinite(ranges)
    time_increment = 1.0 / (6 * int(60.0 * turn.hz))
    header = Header(
        stamp_s=turn.start_s + turn.period_s,
        frame_id="base_scan",
        angle_min=0.0,
        angle_max=math.tau - step,
        angle_increment=step,
        time_increment=time_increment,
        scan_time=_BEAMS * time_increment,
        range_min=0.12,
        range_max=3.5,
    )
    return [header.message(np.where(given, ranges, 0.0), np.where(given, 500.0, 0.0))]


LDS_01 = Driver("lds-01", "lds-01", (5.0,), _publish)
