"""Whether two looks of a robot, taken by different processes, are of one stop."""

import math
from collections.abc import Callable

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import Scan, ScanRequest
from voa_ros.grids import BeamGrid, aligned
from voa_ros.messages import LaserScan
from voa_ros.motions import wrapped
from voa_ros.robots import LookRule
from voa_ros.scans import laser_scan
from voa_ros.scenes import CLEARLY, scene_difference

SameStop = Callable[[ScanRequest, ScanRequest], bool]
"""Whether two looks are of one stop."""


def same_stop(rule: LookRule, grid: BeamGrid) -> SameStop | None:
    """Build the comparison of looks that suits a rule; None where the rule knows no stops.

    Two looks are of one stop where a robot that has had the one would not count as having moved on at the other. It is
    to be asked only of looks that the robot can have had at one time: it may come back to a place later.

    Args:
        rule: when scans are a look.
        grid: of the scenario's lidar.
    """
    if rule.mode != "stationary":
        return None
    return lambda one, other: _at_one_place(one, other, rule) or _of_one_scene(one, other, grid)


def _at_one_place(one: ScanRequest, other: ScanRequest, rule: LookRule) -> bool:
    here, there = one.sensor_pose, other.sensor_pose
    if not isinstance(here, UncertainSensorPose) or not isinstance(there, UncertainSensorPose):
        return False
    near = math.hypot(here.x - there.x, here.y - there.y) <= rule.moved_xy_m
    return near and abs(wrapped(here.yaw_rad - there.yaw_rad)) <= rule.moved_yaw_rad


def _of_one_scene(one: ScanRequest, other: ScanRequest, grid: BeamGrid) -> bool:
    if one.sensor is None or one.sensor != other.sensor:
        return False
    return scene_difference(*aligned(_as_received(one.scan, grid), _as_received(other.scan, grid), grid)) <= CLEARLY


def _as_received(scan: Scan, grid: BeamGrid) -> LaserScan:
    return laser_scan(
        scan,
        grid.angle_min if scan.angle_min is None else scan.angle_min,
        grid.angle_increment if scan.angle_increment is None else scan.angle_increment,
    )
