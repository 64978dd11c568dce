"""Many revolutions as one look, as the service makes it of a ROS robot's."""

import math

import pytest

from voa_fleet.episodes.look_scans import driver_scan, median_look
from voa_fleet.world.lidar import LidarGeometry
from voa_msgs.sessions import Scan

LIDAR = LidarGeometry(beams=4, angle_min=0.1, angle_increment=0.5, range_min=0.12, range_max=3.5, height_m=0.02)


def test_the_median_beam_by_beam_and_a_lost_packet_loses_nothing() -> None:
    scans = [Scan(ranges=[0.30, 0.0, 0.0, 0.5]), Scan(ranges=[0.32, 0.4, 0.0, 0.5]), Scan(ranges=[0.31, 0.4, 1.0, 0.0])]
    look = median_look(scans, LIDAR)
    assert look.ranges == [0.31, 0.4, 0.0, 0.5]
    assert (look.angle_min, look.angle_increment, look.range_min, look.range_max) == (0.1, 0.5, 0.12, 3.5)
    assert look.stamp == {"scans": 3}


def test_what_a_device_says_of_its_beams_wins() -> None:
    scan = Scan(ranges=[0.3, None, 9.0], no_return=[2], angle_min=-1.0, angle_increment=1.0, range_max=2.0)
    message = driver_scan(scan, LIDAR, 12.25)
    assert (message.angle_min, message.angle_max, message.angle_increment) == (-1.0, 1.0, 1.0)
    assert (message.range_min, message.range_max, message.stamp.seconds) == (0.12, 2.0, 12.25)
    assert message.ranges[0] == 0.3
    assert math.isnan(message.ranges[1])
    assert message.ranges[2] == math.inf
    assert median_look([scan], LIDAR).no_return == [2]


def test_no_revolution_is_no_look() -> None:
    with pytest.raises(ValueError, match="at least one scan"):
        median_look([], LIDAR)
