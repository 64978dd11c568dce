"""Decision whether two looks of a robot, gathered by different replicas, were taken at one stop."""

from collections.abc import Callable

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.grids import BeamGrid, aligned
from voa_ros.motions import within
from voa_ros.robots import LookRule
from voa_ros.scans import laser_scan
from voa_ros.scenes import CLEARLY, scene_difference

SameStop = Callable[[ScanRequest, ScanRequest], bool]
"""Predicate that is True for two looks of one stop."""


def same_stop(rule: LookRule, grid: BeamGrid) -> SameStop | None:
    """Build the comparison of looks for a look rule; None where the rule has no stops.

    Two looks are of one stop if the robot would not count as having moved between them. Compare only looks that can be
    of one time, for a robot may come back to a place.

    Args:
        rule: states when scans are a look.
        grid: beam grid of the scenario's lidar.
    """
    if rule.mode != "stationary":
        return None
    return lambda one, other: _at_one_place(one, other, rule) or _of_one_scene(one, other, grid)


def _at_one_place(one: ScanRequest, other: ScanRequest, rule: LookRule) -> bool:
    here, there = one.sensor_pose, other.sensor_pose
    if not isinstance(here, UncertainSensorPose) or not isinstance(there, UncertainSensorPose):
        return False
    return within(here, there, rule.moved_xy_m, rule.moved_yaw_rad)


def _of_one_scene(one: ScanRequest, other: ScanRequest, grid: BeamGrid) -> bool:
    if one.sensor is None or one.sensor != other.sensor:
        return False
    return scene_difference(*aligned(laser_scan(one.scan, grid), laser_scan(other.scan, grid), grid)) <= CLEARLY
