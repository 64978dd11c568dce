"""Repairs of a lidar that is mirrored or turned: the line of the mapping, or the place where the mistake is."""

import math
from dataclasses import dataclass

from voa_client import RobotScan
from voa_console.robots.readings import Reading


@dataclass(frozen=True)
class Repair:
    """Repair of a mistake.

    Attributes:
        words: action that a person should take.
        line: of `robots.toml`, to copy; None: the mistake is not in that file.
    """

    words: str
    line: str | None = None


def repair(reading: Reading, scan: RobotScan) -> Repair | None:
    """Write how to repair a robot whose scan fits in a reading; None: the scan is right as measured.

    Args:
        reading: in which the scan fits.
        scan: of the robot.
    """
    if reading.is_mirrored:
        return _mirrored(scan)
    return _turned(reading.turned_degrees, scan) if reading.turned_degrees else None


def _mirrored(scan: RobotScan) -> Repair:
    if scan.source == "scan":
        words = "In the program that publishes the scans, make angle_min and angle_increment count counter-clockwise."
        return Repair(words)
    words = (
        f'In robots.toml, at name = "{scan.robot}", keep x, y and yaw_rad of lidar and add upside_down = true (take it '
        "out if it is there already). It is for a lidar that hangs, or a driver that turns clockwise."
    )
    return Repair(words, "lidar = { upside_down = true }")


def _turned(degrees: int, scan: RobotScan) -> Repair:
    if scan.sensor is not None:
        back = f"turn the lidar by {degrees}° clockwise"
        return Repair(
            f"At sensor {scan.sensor!r}, {back}, or add {degrees}° to yaw_rad of that sensor in the scenario."
        )
    radians = math.remainder(math.radians(degrees), math.tau)
    signed = math.degrees(radians)
    if scan.source == "scan":
        return Repair(
            f"In the program that publishes the scans, add {radians:.4f} ({signed:+.0f}°) to yaw_rad of sensor_pose."
        )
    words = (
        f'In robots.toml, at name = "{scan.robot}", add {radians:.4f} ({signed:+.0f}°) to yaw_rad of lidar, and keep '
        "its x and y. If it is 0 now:"
    )
    return Repair(words, f"lidar = {{ yaw_rad = {radians:.4f} }}")
