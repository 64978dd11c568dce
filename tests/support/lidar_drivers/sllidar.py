"""RPLIDAR A1, A2, C1 and S2 by Slamtec's sllidar_ros2 (src/sllidar_node.cpp at commit 0260640, its launch files).

Modelled, with `angle_compensate` as in all launch files: samples on a clock of their own, clockwise, ranges to 1/4 mm;
360 m beams from -pi to pi, both included, where m is the whole part of one more than the samples of a degree at 10 Hz
(A1 1, A2 3, C1 2, S2 9), always the same; a point goes to the beam below its clockwise angle and to the m - 1 after
it, and a later point overwrites; the array is then turned round; a beam with no point or range 0 is +inf, never 0 or
NaN, so that an A1, with fewer samples than beams, has a quarter to a half of them +inf in each revolution, others each
time; range_min 0.15 m, range_max that of the scan mode; frame `laser`; the stamp is taken before the revolution.

Not modelled: `angle_compensate: false`, the node's own default, with one beam for each point and the first and last
valid points as limits. Not verified: the range_max that a C1 reports (taken to be 16 m), the sampling rates that each
reports, and how fast a real motor wanders (an assumption: 0.3 %).
"""

import math

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from voa_ros.messages import LaserScan


def _publish(turn: Turn, rate_hz: float, range_max: float) -> list[LaserScan]:
    clockwise = turn.phases(rate_hz)
    ranges = quantised(turn.measure(math.pi - clockwise), 0.00025)
    multiple = int(int(rate_hz / 10.0) / 360.0 + 1.0)
    beams = 360 * multiple
    nodes = np.zeros(beams)
    for phase, value in zip(clockwise, ranges, strict=True):
        if math.isfinite(value):
            first = int(math.degrees(phase) * multiple)
            nodes[first : first + multiple] = value
    beam_ranges = np.where(nodes == 0.0, np.inf, nodes)[::-1]
    header = Header(
        stamp_s=turn.start_s,
        frame_id="laser",
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=math.tau / (beams - 1),
        time_increment=turn.period_s / (beams - 1),
        scan_time=turn.period_s,
        range_min=0.15,
        range_max=range_max,
    )
    return [header.message(beam_ranges, np.where(np.isinf(beam_ranges), 0.0, 47.0))]


def _publish_a1(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 2000.0, 12.0)


def _publish_a2(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 7936.0, 12.0)


def _publish_c1(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 5000.0, 16.0)


def _publish_s2(turn: Turn) -> list[LaserScan]:
    return _publish(turn, 32000.0, 30.0)


A1 = Driver("rplidar-a1", "rplidar-a1", (5.5, 7.5), _publish_a1, reach_increments=1.0, wandering=0.003)
A2 = Driver("rplidar-a2", "rplidar-a2", (5.0, 10.0), _publish_a2, reach_increments=3.0, wandering=0.003)
C1 = Driver("rplidar-c1", "rplidar-c1", (10.0,), _publish_c1, reach_increments=2.0, wandering=0.003)
S2 = Driver("rplidar-s2", "rplidar-s2", (10.0,), _publish_s2, reach_increments=9.0, wandering=0.003)
