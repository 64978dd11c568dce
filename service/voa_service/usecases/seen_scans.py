"""Newest scan of each robot, in memory, for a preview: kept as it was decoded, and converted when it is read."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import Scan, ScanRequest
from voa_ros.pipeline import SeenScan as DecodedScan
from voa_ros.scans import scan_message

Source = Literal["scan", "ros2"]
"""Origin of the scans of a robot."""
_MOST = 100  # robots; the bus lets anyone publish under any name


@dataclass(frozen=True)
class SeenScan:
    """A scan, with the time and the place at which it was received.

    Attributes:
        at: time of receipt.
        sensor: name of the sensor configuration; None: `sensor_pose` states where, or it is not known.
        sensor_pose: pose of the lidar; None: `sensor` states where, or it is not known.
        message: makes the message of the scan.
        session: id of the session that the scan is for; None: not known yet.
    """

    at: datetime
    sensor: str | None
    sensor_pose: UncertainSensorPose | None
    message: Callable[[], Scan]
    session: str | None


def of_request(request: ScanRequest, at: datetime, session: str) -> SeenScan:
    """Keep the scan of a request to update the belief of a session."""
    return SeenScan(at, request.sensor, request.sensor_pose, lambda: request.scan, session)


def of_decoded(decoded: DecodedScan, at: datetime, session: str | None) -> SeenScan:
    """Keep a scan of a mapped robot, with the session that the robot has joined by then, if any."""
    where = decoded.where
    name, pose = (where, None) if isinstance(where, str) else (None, where)
    return SeenScan(at, name, pose, lambda: scan_message(decoded.scan), session)


class SeenScans:
    """Collection of the newest scan of each robot, of at most 100 robots; its owner guards it by a lock."""

    def __init__(self) -> None:
        self._scans: dict[tuple[str, Source], SeenScan] = {}

    def keep(self, robot: str, source: Source, scan: SeenScan) -> None:
        """Replace the scan of a robot; beyond the limit the robot is dropped that was silent for longest."""
        self._scans.pop((robot, source), None)
        self._scans[robot, source] = scan
        if len(self._scans) > _MOST:
            del self._scans[next(iter(self._scans))]

    def drop(self, robot: str, source: Source) -> None:
        """Forget the scan of a robot, if there is one."""
        self._scans.pop((robot, source), None)

    def get(self, robot: str, source: Source) -> SeenScan | None:
        """Return the newest scan of a robot from one origin; None: there is none."""
        return self._scans.get((robot, source))

    def newest(self, robot: str) -> tuple[Source, SeenScan] | None:
        """Return the newest scan of a robot, and its origin; None: there is none."""
        sources: tuple[Source, ...] = ("ros2", "scan")
        seen = [(source, scan) for source in sources if (scan := self.get(robot, source)) is not None]
        return max(seen, key=lambda each: each[1].at, default=None)
