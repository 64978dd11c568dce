"""Fields that several messages of ROS share: headers, stamps, poses."""

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from voa_ros.messages import NANOSECONDS
from voa_scene.rotations import cross
from voa_scene.shapes import Quaternion, Vector

Fields = dict[str, Any]
"""Message of ROS: its fields by name; nested messages are dictionaries, sequences are lists."""


def stamp_of(at: datetime) -> Fields:
    """Write a time as a `builtin_interfaces/msg/Time`."""
    sec, rest = divmod(round(at.timestamp() * 1e6), 1_000_000)
    return {"sec": sec, "nanosec": rest * (NANOSECONDS // 1_000_000)}


def header(frame_id: str, at: datetime | None = None) -> Fields:
    """Write a `std_msgs/msg/Header`.

    Args:
        frame_id: name of the frame.
        at: time of the content; None: the stamp is 0, by which tools take the newest transform of the frame, so that
            the clocks of service and robot need not agree.
    """
    return {"frame_id": frame_id} if at is None else {"frame_id": frame_id, "stamp": stamp_of(at)}


def point(position: Sequence[float]) -> Fields:
    """Write x, y, z in metres as a `geometry_msgs/msg/Point` or `Vector3`."""
    x, y, z = position
    return {"x": float(x), "y": float(y), "z": float(z)}


def pose(position: Sequence[float], quaternion_wxyz: Sequence[float]) -> Fields:
    """Write a `geometry_msgs/msg/Pose`: position in metres, orientation as a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion_wxyz
    orientation = {"x": float(x), "y": float(y), "z": float(z), "w": float(w)}
    return {"position": point(position), "orientation": orientation}


def turned(rotation: Quaternion, vector: Vector) -> Vector:
    """Turn a vector by a rotation."""
    w, x, y, z = rotation
    axis = (x, y, z)
    twice = cross(axis, vector)
    half = (twice[0] + w * vector[0], twice[1] + w * vector[1], twice[2] + w * vector[2])
    moved = cross(axis, half)
    return (vector[0] + 2.0 * moved[0], vector[1] + 2.0 * moved[1], vector[2] + 2.0 * moved[2])
