"""A look: many revolutions of a lidar that stands still, as one scan."""

from collections.abc import Sequence

from voa_fleet.world.lidar import REVOLUTION_S, LidarGeometry
from voa_msgs.sessions import Scan
from voa_ros.grids import BeamGrid
from voa_ros.messages import LaserScan, Stamp
from voa_ros.scans import median_scan, scan_message

FRAME = "base_scan"
REVOLUTIONS = 10
"""Two seconds of an LDS-01, and what a mapping of ROS robots takes if it does not say."""
_MISSING, _NOTHING = float("nan"), float("inf")


def laser_scan(scan: Scan, lidar: LidarGeometry, at_s: float) -> LaserScan:
    """A device's scan as a ROS driver would publish it, stamped with its first ray.

    Args:
        scan: as the device gave it; what it does not say of its beams is the lidar's.
        lidar: the beams.
        at_s: when the revolution began, seconds by the robot's clock.
    """
    first = lidar.angle_min if scan.angle_min is None else scan.angle_min
    apart = lidar.angle_increment if scan.angle_increment is None else scan.angle_increment
    empty = set(scan.no_return)
    return LaserScan(
        stamp=Stamp.of(at_s),
        frame_id=FRAME,
        angle_min=first,
        angle_max=first + apart * (len(scan.ranges) - 1),
        angle_increment=apart,
        time_increment=REVOLUTION_S / len(scan.ranges),
        scan_time=REVOLUTION_S,
        range_min=lidar.range_min if scan.range_min is None else scan.range_min,
        range_max=lidar.range_max if scan.range_max is None else scan.range_max,
        ranges=tuple(
            _NOTHING if index in empty else _MISSING if value is None else value
            for index, value in enumerate(scan.ranges)
        ),
    )


def median_look(scans: Sequence[Scan], lidar: LidarGeometry) -> Scan:
    """The per-beam median of revolutions from one place; see `voa_ros.scans.median_scan`.

    Raises:
        ValueError: there is none.
    """
    grid = BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
    received = [laser_scan(scan, lidar, 0.0) for scan in scans]
    return scan_message(median_scan(received, grid), stamp={"scans": len(scans)})
