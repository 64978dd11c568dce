"""Look of a robot: the median of several revolutions at the mean of their poses, as an update of a belief."""

import hashlib
import statistics
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.grids import BeamGrid
from voa_ros.messages import LaserScan
from voa_ros.motions import wrapped
from voa_ros.scans import median_scan, scan_message, stamp_json

Where = UncertainSensorPose | str
"""Pose of the lidar in the world, or the name of a sensor configuration of the scenario."""


@dataclass(frozen=True)
class GatheredLook:
    """Look that was gathered from the revolutions of a robot.

    Attributes:
        digest: digest of its times and ranges, hexadecimal; equal for all that receive the same revolutions.
        request: request to update a belief; the `stamp` of its scan is `{"robot", "from", "to", "scans", "frame_id"}`.
    """

    digest: str
    request: ScanRequest


@dataclass(frozen=True)
class Waiting:
    """Result where there is no look yet, with the condition that is not met, in words."""

    reason: str


@dataclass(frozen=True)
class Revolution:
    """Scan of one revolution, and the place from which it was taken."""

    scan: LaserScan
    where: Where


def look_name(robot: str, session: str, number: int, look: GatheredLook) -> str:
    """Return the name of a look, which is the idempotency key of its update.

    The number is part of the name, because equal times and ranges may occur again.

    Args:
        robot: name of the robot in the mapping.
        session: identifier of the session to which the look is applied.
        number: number of looks of this robot that the session has accepted, plus one.
        look: the look.
    """
    return f"{robot}:{session}:{number}:{look.digest}"


def robot_of(request: ScanRequest) -> str | None:
    """Return the name of the robot whose look a request of a session's history is; None: it is no look of a robot."""
    stamp = request.scan.stamp
    robot = stamp.get("robot") if isinstance(stamp, dict) else None
    return robot if isinstance(robot, str) else None


def look_of(robot: str, revolutions: Sequence[Revolution], grid: BeamGrid) -> GatheredLook:
    """Make a look from revolutions.

    Args:
        robot: name of the robot.
        revolutions: at least one, from places that are close together.
        grid: grid of the scenario's lidar, for revolutions whose beams differ.
    """
    scans = [revolution.scan for revolution in revolutions]
    first, last = scans[0].stamp, scans[-1].stamp
    stamp: dict[str, Any] = {
        "robot": robot,
        "from": stamp_json(first),
        "to": stamp_json(last),
        "scans": len(scans),
        "frame_id": scans[0].frame_id,
    }
    median = median_scan(scans, grid)
    where = _middle([revolution.where for revolution in revolutions])
    request = ScanRequest(
        sensor=where if isinstance(where, str) else None,
        sensor_pose=None if isinstance(where, str) else where,
        scan=scan_message(median, stamp),
    )
    times = struct.pack("<4q", first.sec, first.nanosec, last.sec, last.nanosec)
    ranges = struct.pack(f"<{len(median.ranges)}d", *median.ranges)
    return GatheredLook(hashlib.blake2b(times + ranges, digest_size=16).hexdigest(), request)


def _middle(places: Sequence[Where]) -> Where:
    """Mean of poses that are close together; a name of a sensor configuration is returned unchanged."""
    first = places[0]
    poses = [place for place in places if isinstance(place, UncertainSensorPose)]
    if isinstance(first, str) or len(poses) == 1:
        return first
    turned = statistics.fmean(wrapped(pose.yaw_rad - first.yaw_rad) for pose in poses)
    return first.model_copy(
        update={
            "x": statistics.fmean(pose.x for pose in poses),
            "y": statistics.fmean(pose.y for pose in poses),
            "yaw_rad": wrapped(first.yaw_rad + turned),
        }
    )
