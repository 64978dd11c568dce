"""Readings of a scan: as measured, mirrored, or turned, to see which of them fits the prediction."""

import math
from dataclasses import dataclass

from voa_client import Scan
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.lidars import Lidar

_CHANGED_M = 0.03
_CHANGED_BEAMS = 4


@dataclass(frozen=True)
class Reading:
    """Way to read the directions of the beams of a scan.

    Attributes:
        name: in words, for a button.
        is_mirrored: True if the beams are taken in reverse.
        turned_degrees: angle by which the lidar's yaw is more than stated.
    """

    name: str
    is_mirrored: bool = False
    turned_degrees: int = 0


AS_MEASURED = Reading("As measured")
MIRRORED = Reading("Mirrored", is_mirrored=True)
TURNED = tuple(Reading(f"Turned by {degrees}°", turned_degrees=degrees) for degrees in (90, 180, 270))
READINGS = (AS_MEASURED, MIRRORED, *TURNED)


def read(reading: Reading, scan: Scan, place: UncertainSensorPose, lidar: Lidar) -> tuple[Scan, UncertainSensorPose]:
    """Read a scan in another way; the result states the angles of its beams.

    Args:
        reading: the way.
        scan: as it was received.
        place: pose of the lidar, as stated.
        lidar: of the scenario, for angles that the scan does not state.
    """
    first = scan.angle_min if scan.angle_min is not None else lidar.angle_min or 0.0
    step = scan.angle_increment if scan.angle_increment is not None else lidar.angle_increment or 0.0
    sign = -1.0 if reading.is_mirrored else 1.0
    turned = place.model_copy(update={"yaw_rad": place.yaw_rad + math.radians(reading.turned_degrees)})
    return scan.model_copy(update={"angle_min": sign * first, "angle_increment": sign * step}), turned


def differs(one: Scan, other: Scan) -> bool:
    """True if two scans from one place show different scenes: several beams differ by more than the lidar's noise."""
    if (len(one.ranges), one.angle_increment) != (len(other.ranges), other.angle_increment):
        return True
    pairs = zip(one.ranges, other.ranges, strict=True)
    changes = [abs(a - b) for a, b in pairs if a is not None and b is not None]
    return sum(change > _CHANGED_M for change in changes) >= _CHANGED_BEAMS
