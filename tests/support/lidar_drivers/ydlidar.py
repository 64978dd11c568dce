"""YDLIDAR X4 and TG15 by ydlidar_ros2_driver (node at commit 044dcd3) and YDLidar-SDK (CYdLidar at commit 03e0cc7).

Modelled: samples on a clock of their own (X4 5 000, TG15 20 000 a second), clockwise, turned and mirrored as
params/X4.yaml and params/TG.yaml say (`reversion`, `inverted`); every message covers -pi to pi, both included, and the
increment is a turn by one less than the points of the revolution; the beams are the whole part of the quotient of
both, one of float32, plus one; a point goes to the beam above its angle; ranges begin as 0 and stay so for a beam
without a point and for a range outside the limits of the file (X4 0.1 to 12 m, TG 0.01 to 50 m), never NaN or inf;
no intensities are measured; frame `laser_frame`; the stamp is that of the first point.

Not modelled: `fixed_resolution: true`, with which the beams are sampling rate by frequency less 0.1 Hz: the node's own
default is false, and what public reports show varies (issues 15 of ydlidar_ros2_driver and 4 of ydlidar_ros_driver);
the X4's correction of angles at short range. Not verified: how fast a real motor wanders (an assumption: 0.3 %).
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from voa_ros.messages import LaserScan


def _publish(turn: Turn, rate_hz: float, step_m: float, near_m: float, far_m: float) -> list[LaserScan]:
    directions = math.pi - turn.phases(rate_hz)
    ranges = quantised(turn.measure(directions), step_m)
    points = len(directions)
    low, high = np.float32(-math.pi), np.float32(math.pi)
    increment = np.float32(math.tau / (points - 1))
    beams = int((high - low) / increment + np.float32(1.0))
    index = np.ceil((directions.astype(np.float32) - low) / increment).astype(int)
    inside = (ranges >= near_m) & (ranges <= far_m) & (index >= 0) & (index < beams)
    beam_ranges = np.zeros(beams)
    beam_ranges[index[inside]] = ranges[inside]
    header = Header(
        stamp_s=turn.start_s,
        frame_id="laser_frame",
        angle_min=float(low),
        angle_max=float(high),
        angle_increment=float(increment),
        time_increment=1.0 / rate_hz,
        scan_time=(points - 1) / rate_hz,
        range_min=near_m,
        range_max=far_m,
    )
    return [header.message(beam_ranges, np.zeros(beams))]


def _publish_x4(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 5000.0, 0.00025, 0.1, 12.0)


def _publish_tg15(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 20000.0, 0.001, 0.01, 50.0)


X4 = Driver("ydlidar-x4", "ydlidar-x4", (7.0, 10.0), _publish_x4, reach_increments=1.0, wandering=0.003)
TG15 = Driver("ydlidar-tg15", "ydlidar-tg15", (5.0, 10.0), _publish_tg15, reach_increments=1.0, wandering=0.003)
