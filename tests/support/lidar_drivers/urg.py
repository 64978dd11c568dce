"""Hokuyo UST-10LX and URG-04LX by Hokuyo's urg_node2 (src/urg_node2.cpp at commit 54af63e, urg_library 815a110).

Modelled: the sensor's own steps, always the same (UST-10LX 1 081 of 1/1440 turn, URG-04LX 682 of 1/1024), counter-
clockwise; ranges to 1 mm; a range of 0 is NaN; limits and period are those that the sensor reports (UST-10LX 0.02 to
30 m and 25 ms, URG-04LX 0.02 to 5.6 m and 100 ms), whatever the datasheet guarantees; no intensities; frame `laser`;
the stamp is that of the first ray. Where nothing is in range a UST-10LX sends 65.533 m, beyond range_max, and a
URG-04LX 0, or now and then an error code below 20 mm, which is passed on as a range below range_min.

Not verified: 65.533 m and the UST-10LX's reported limits (from memory of recordings, no source was at hand), and how
often there are error codes (an assumption: 2 % of the beams with nothing in range).
"""

import math
from dataclasses import dataclass

import numpy as np

from tests.support.lidar_drivers.driver import Driver, Header, Turn, quantised
from tests.support.lidar_drivers.scene import Floats
from voa_ros.messages import LaserScan


@dataclass(frozen=True)
class _Sensor:
    first_step: int
    last_step: int
    steps_per_turn: int
    range_min: float
    range_max: float
    period_s: float


def _header(turn: Turn, sensor: _Sensor) -> Header:
    step = math.tau / sensor.steps_per_turn
    low = step * sensor.first_step
    return Header(
        stamp_s=turn.start_s + (low + math.pi) / math.tau * sensor.period_s,
        frame_id="laser",
        angle_min=low,
        angle_max=step * sensor.last_step,
        angle_increment=step,
        time_increment=sensor.period_s / sensor.steps_per_turn,
        scan_time=sensor.period_s,
        range_min=sensor.range_min,
        range_max=sensor.range_max,
    )


def _measured(turn: Turn, sensor: _Sensor) -> Floats:
    steps = np.arange(sensor.first_step, sensor.last_step + 1)
    return quantised(turn.measure(math.tau / sensor.steps_per_turn * steps), 0.001)


def _publish_ust_10lx(turn: Turn) -> list[LaserScan]:
    sensor = _Sensor(-540, 540, 1440, 0.02, 30.0, 0.025)
    ranges = _measured(turn, sensor)
    return [_header(turn, sensor).message(np.where(np.isinf(ranges), 65.533, ranges))]


def _publish_urg_04lx(turn: Turn) -> list[LaserScan]:
    sensor = _Sensor(44 - 384, 725 - 384, 1024, 0.02, 5.6, 0.1)
    ranges = _measured(turn, sensor)
    codes = np.where(turn.rng.random(len(ranges)) < 0.02, 0.007, np.nan)
    return [_header(turn, sensor).message(np.where(np.isinf(ranges), codes, ranges))]


UST_10LX = Driver("hokuyo-ust-10lx", "hokuyo-ust-10lx", (40.0,), _publish_ust_10lx)
URG_04LX = Driver("hokuyo-urg-04lx", "hokuyo-urg-04lx", (10.0,), _publish_urg_04lx)
