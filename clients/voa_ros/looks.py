"""A look: the median of some revolutions at the mean of their places, as an update of a belief."""

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
"""A pose of the lidar in the world, or the name of one of the scenario's sensor configurations."""


@dataclass(frozen=True)
class GatheredLook:
    """A look.

    Attributes:
        digest: of its times and ranges, hexadecimal; the same wherever the same revolutions are received.
        request: the update. Its scan's `stamp` is `{"robot", "from", "to", "scans", "frame_id"}`.
    """

    digest: str
    request: ScanRequest


@dataclass(frozen=True)
class Waiting:
    """No look yet, and the condition that is not met."""

    reason: str


@dataclass(frozen=True)
class Revolution:
    """A whole turn of the lidar, and where it was taken."""

    scan: LaserScan
    where: Where


def look_name(robot: str, session: str, number: int, taken: GatheredLook) -> str:
    """Name of a robot's look, the idempotency key of its update; times and ranges may come again, numbers do not.

    Args:
        robot: name in the mapping.
        session: that the look is for.
        number: one more than the looks of this robot that the session has accepted.
        taken: the look.
    """
    return f"{robot}:{session}:{number}:{taken.digest}"


def robot_of(request: ScanRequest) -> str | None:
    """Name of the robot whose look a session's history holds; None where it is not one that was taken here."""
    stamp = request.scan.stamp
    robot = stamp.get("robot") if isinstance(stamp, dict) else None
    return robot if isinstance(robot, str) else None


def look_of(robot: str, revolutions: Sequence[Revolution], grid: BeamGrid) -> GatheredLook:
    """Make a look of revolutions.

    Args:
        robot: name of the robot.
        revolutions: at least one, from places that lie close together.
        grid: beams of the scenario's lidar, for revolutions whose beams differ.
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
    """The mean of poses that lie close together; of a name, the name."""
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
