"""Recordings as ROS 2 makes them, by rosbags' own writer."""

from collections.abc import Sequence
from pathlib import Path

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from voa_cli.recordings.ros_types import LASER_SCAN
from voa_ros.cdr import encode_laser_scan
from voa_ros.messages import LaserScan, Stamp

STORE = get_typestore(Stores.ROS2_JAZZY)
START_NS = 1_760_000_000_000_000_000
STEP_NS = 200_000_000

Written = tuple[str, str, int, bytes]
"""Topic, type, time, payload."""


def laser_scan(ranges: Sequence[float], at_ns: int = START_NS, **changes: float) -> LaserScan:
    """A revolution."""
    figures = {
        "angle_min": 0.0, "angle_max": 6.265732, "angle_increment": 0.017453292, "time_increment": 0.0,
        "scan_time": 0.0, "range_min": 0.12, "range_max": 3.5,
    } | changes  # fmt: skip
    stamp = Stamp(at_ns // 1_000_000_000, at_ns % 1_000_000_000)
    return LaserScan(stamp=stamp, frame_id="base_scan", ranges=tuple(ranges), intensities=(), **figures)


def scans(count: int, topic: str = "/scan") -> list[Written]:
    """Revolutions that differ, one each 0.2 s."""
    made = []
    for index in range(count):
        at = START_NS + index * STEP_NS
        made.append((topic, LASER_SCAN, at, encode_laser_scan(laser_scan([0.5 + index / 100] * 360, at))))
    return made


def bag(folder: Path, messages: Sequence[Written], storage: StoragePlugin) -> Path:
    """A rosbag2 folder."""
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        connections = {
            topic: writer.add_connection(topic, type_name, typestore=STORE)
            for topic, type_name in {message[0]: message[1] for message in messages}.items()
        }
        for topic, _, at, payload in messages:
            writer.write(connections[topic], at, payload)
    return folder
