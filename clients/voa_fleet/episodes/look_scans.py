"""The scan of a look: many revolutions of a lidar that stands still, as one."""

from collections.abc import Sequence
from dataclasses import replace

from voa_fleet.world.lidar import REVOLUTION_S, LidarGeometry
from voa_msgs.sessions import Scan
from voa_ros.grids import BeamGrid
from voa_ros.messages import LaserScan, Stamp
from voa_ros.scans import laser_scan, median_scan, scan_message

FRAME = "base_scan"
REVOLUTIONS = 10
"""Revolutions in a look: two seconds of an LDS-01, and the default of a mapping of ROS robots."""


def driver_scan(scan: Scan, lidar: LidarGeometry, at_s: float) -> LaserScan:
    """Convert a device's scan to the LaserScan that a ROS driver would publish, stamped with its first ray.

    Args:
        scan: of one revolution; angles and limits that it does not state are the lidar's.
        lidar: beams and limits.
        at_s: when the revolution began, seconds by the robot's clock.
    """
    return replace(
        laser_scan(scan, _grid(lidar)),
        stamp=Stamp.of(at_s),
        frame_id=FRAME,
        time_increment=REVOLUTION_S / len(scan.ranges),
        scan_time=REVOLUTION_S,
        range_min=lidar.range_min if scan.range_min is None else scan.range_min,
        range_max=lidar.range_max if scan.range_max is None else scan.range_max,
    )


def median_look(scans: Sequence[Scan], lidar: LidarGeometry) -> Scan:
    """Take the median of each beam over revolutions from one place, as `voa_ros.scans.median_scan` does.

    Raises:
        ValueError: there is no scan.
    """
    received = [driver_scan(scan, lidar, 0.0) for scan in scans]
    return scan_message(median_scan(received, _grid(lidar)), stamp={"scans": len(scans)})


def _grid(lidar: LidarGeometry) -> BeamGrid:
    return BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
