"""Readings of a scan: the directions of its beams change, its ranges do not."""

import math

import pytest

from voa_client import Scan
from voa_console.robots.readings import AS_MEASURED, MIRRORED, READINGS, TURNED, differs, read
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.lidars import Lidar

LIDAR = Lidar(angle_min=0.5, angle_increment=0.1)
PLACE = UncertainSensorPose(x=1.0, y=2.0, yaw_rad=0.25)
RANGES = [0.5, None, 0.75, 1.0, 1.0, 1.0]


def test_as_measured_the_angles_of_the_lidar_are_written_out() -> None:
    scan, place = read(AS_MEASURED, Scan(ranges=RANGES), PLACE, LIDAR)
    assert (scan.angle_min, scan.angle_increment, scan.ranges, place) == (0.5, 0.1, RANGES, PLACE)


def test_mirrored_the_angles_count_the_other_way() -> None:
    scan, place = read(MIRRORED, Scan(ranges=RANGES, angle_min=-1.0, angle_increment=0.2), PLACE, LIDAR)
    assert (scan.angle_min, scan.angle_increment, scan.ranges, place) == (1.0, -0.2, RANGES, PLACE)


def test_turned_the_lidar_has_another_yaw() -> None:
    yaws = [read(reading, Scan(ranges=RANGES), PLACE, LIDAR)[1].yaw_rad - PLACE.yaw_rad for reading in TURNED]
    assert yaws == pytest.approx([math.pi / 2, math.pi, 3 * math.pi / 2])
    assert len({reading.name for reading in READINGS}) == 5


def test_noise_and_missing_beams_are_no_other_scene() -> None:
    scan = Scan(ranges=RANGES)
    assert not differs(scan, Scan(ranges=[0.51, 0.4, None, 1.01, 0.99, 1.0]))
    assert not differs(scan, Scan(ranges=[0.51, 0.4, 3.0, 3.0, 3.0, 1.0]))
    assert differs(scan, Scan(ranges=[0.51, 0.4, 3.0, 3.0, 3.0, 3.0]))
    assert differs(scan, Scan(ranges=RANGES[:-1]))
