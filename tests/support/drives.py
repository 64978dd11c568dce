"""Robots that drive from stop to stop around a box on a table, and the messages that their drivers publish.

The scene is a box in one of four yaws in a square room (`tests.support.lidar_drivers`). The scenario has the same box
as a mesh, so that a look from any stop must find the yaw in which the box really lies.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.support.lidar_drivers.driver import Driver
from tests.support.lidar_drivers.scene import Scene
from tests.support.serving import box_obj
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.files.writer import RecordingWriter
from voa_ros.cdr import decode_laser_scan, decode_odometry, encode_laser_scan, encode_odometry
from voa_ros.messages import LaserScan, Odometry, Pose, Stamp
from voa_ros.topics import LASER_SCAN, ODOMETRY, MessageType

Place = tuple[float, float, float]
"""x and y in metres, yaw in radians."""

BOX = (0.05, 0.12, 0.1)
YAWS = {"A": 0.0, "B": 90.0, "C": 45.0, "D": 135.0}
RADIUS_M = 0.45
STANDING_S, DRIVING_S = 3.4, 2.0
ODOMETRY_HZ = 20.0
START_S = 1000.0
SCAN, ODOM = "scan", "odom"

Change = Callable[[int, LaserScan], LaserScan]
"""Fault of a driver or a connection: a function of the number of a scan and the scan as it was published."""


class Put(NamedTuple):
    """Message as it arrives."""

    at_s: float
    topic: str
    type: MessageType
    payload: bytes


def box() -> str:
    """The box as an OBJ file."""
    return box_obj(*BOX)


def around(count: int) -> list[Place]:
    """Places on a circle around the box, directed at it, none of which is symmetric to another."""
    angles = [0.3 + math.tau * 0.31 * step for step in range(count)]
    return [(RADIUS_M * math.cos(a), RADIUS_M * math.sin(a), math.remainder(a + math.pi, math.tau)) for a in angles]


def scenario(object_id: str, preset: str, **changes: Any) -> dict[str, Any]:
    """The scenario of the box, with a lidar of a preset."""
    poses = [
        {
            "name": name,
            "position": [0, 0, 0],
            "quaternion_wxyz": [math.cos(math.radians(yaw) / 2), 0, 0, math.sin(math.radians(yaw) / 2)],
        }
        for name, yaw in YAWS.items()
    ]
    return {
        "name": f"box-{preset}",
        "object": object_id,
        "poses": poses,
        "grasps": [{"name": f"G{name}"} for name in YAWS],
        "scores": {"attempts": 10, "successes": [[9 if g == p else 1 for p in range(4)] for g in range(4)]},
        "sensors": [{"name": "E", "x": RADIUS_M, "y": 0.0, "yaw_rad": math.pi}],
        "lidar": {"preset": preset, "height_m": 0.05},
        "update": {"rule": "beam"},
        "workspace": {"min": [-0.15, -0.15], "max": [0.15, 0.15]},
    } | changes


@dataclass(frozen=True)
class Drive:
    """Drive of a robot from stop to stop.

    Attributes:
        stops: places of the lidar (which is the robot's own centre here).
        standing_s: seconds at each stop.
        driving_s: seconds from one stop to the next.
    """

    stops: Sequence[Place]
    standing_s: float = STANDING_S
    driving_s: float = DRIVING_S

    @property
    def seconds(self) -> float:
        """Length of the whole drive, which ends with a short departure from the last stop."""
        return len(self.stops) * (self.standing_s + self.driving_s)

    def pose_at(self, at_s: float) -> Place:
        """Pose of the robot at a time; before and after the drive, at its ends."""
        period = self.standing_s + self.driving_s
        leg = min(max(int((at_s - START_S) // period), 0), len(self.stops) - 1)
        share = max(0.0, at_s - START_S - leg * period - self.standing_s) / self.driving_s
        here, there = self.stops[leg], (self.stops[(leg + 1) % len(self.stops)] if len(self.stops) > 1 else None)
        if there is None:
            return here
        turn = math.remainder(there[2] - here[2], math.tau)
        share = min(share, 1.0)
        return (
            here[0] + share * (there[0] - here[0]),
            here[1] + share * (there[1] - here[1]),
            math.remainder(here[2] + share * turn, math.tau),
        )


def published(
    drive: Drive, driver: Driver, hz: float, *, seed: int = 1, yaw: str = "A", change: Change | None = None
) -> list[Put]:
    """Compute all messages that a robot publishes on a drive, in the order of arrival.

    Args:
        drive: stops and times.
        driver: driver of the lidar.
        hz: revolutions per second.
        seed: seed of the noise.
        yaw: name of the yaw in which the box lies.
        change: fault that is applied to each scan.
    """
    scene = Scene.room(1.5, [(0.0, 0.0, BOX[0], BOX[1], math.radians(YAWS[yaw]))])
    rng = np.random.default_rng(seed)
    scans = driver.play(scene, drive.pose_at, int(drive.seconds * hz), hz, rng, START_S)
    puts = []
    for number, scan in enumerate(scans):
        arrives_s = scan.stamp.seconds + (scan.scan_time if math.isfinite(scan.scan_time) else 0.0)
        changed = scan if change is None else change(number, scan)
        puts.append(Put(arrives_s, SCAN, LASER_SCAN, encode_laser_scan(changed)))
    for step in range(int(drive.seconds * ODOMETRY_HZ)):
        at_s = START_S + step / ODOMETRY_HZ
        x, y, turned = drive.pose_at(at_s)
        odometry = Odometry(Stamp.of(at_s), "odom", "base_footprint", Pose.planar(x, y, turned))
        puts.append(Put(at_s, ODOM, ODOMETRY, encode_odometry(odometry)))
    return sorted(puts, key=lambda put: put.at_s)


def record(path: Path, puts: Iterable[Put]) -> Path:
    """Write the messages into an MCAP file, as a recorder of ROS 2 would."""
    with path.open("wb") as file:
        writer = RecordingWriter(file, RosTypes())
        for put in puts:
            at_ns = round(put.at_s * 1e9)
            writer.add_ros(f"/{put.topic}", put.type.name, put.payload, log_ns=at_ns, publish_ns=at_ns, key=put.topic)
        writer.finish()
    return path


def restamped(puts: Iterable[Put], stamp: Callable[[Stamp], Stamp], *, odometry: bool = True) -> list[Put]:
    """Replace the stamps of messages, as a robot with a wrong clock would.

    Args:
        puts: messages with right stamps.
        stamp: converts a right stamp to a wrong one.
        odometry: True to replace the stamps of the odometry too.
    """
    messages = []
    for put in puts:
        if put.type == LASER_SCAN:
            scan = decode_laser_scan(put.payload, 30_000)
            messages.append(put._replace(payload=encode_laser_scan(replace(scan, stamp=stamp(scan.stamp)))))
        elif odometry:
            pose = decode_odometry(put.payload)
            messages.append(put._replace(payload=encode_odometry(replace(pose, stamp=stamp(pose.stamp)))))
        else:
            messages.append(put)
    return messages
