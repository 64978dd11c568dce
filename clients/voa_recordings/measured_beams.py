"""Ranges of a look as a recorded experiment holds them: on the grid of the lidar, and of the object alone."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar
from voa_msgs.scenarios import Workspace
from voa_msgs.sessions import Scan
from voa_ros.grids import BeamGrid, on_grid
from voa_ros.scans import laser_scan
from voa_scene.scans import crossing


@dataclass(frozen=True)
class MeasuredBeams:
    """Ranges that were measured from one place.

    Attributes:
        ranges: metres, one for each beam of the lidar; None for a no-return, and for a missing beam.
        missing: number of beams that say nothing, which a recorded experiment cannot state.
    """

    ranges: Sequence[float | None]
    missing: int


def measured_beams(
    scan: Scan, grid: BeamGrid, lidar: Lidar, place: SensorPose, workspace: Workspace | None
) -> MeasuredBeams:
    """Classify the beams of a scan as the service does, and keep the returns of the object.

    A beam below the range limit is missing and one above it is a no-return; within a workspace, a return before the
    beam enters it is missing, and one behind it is a no-return.

    Args:
        scan: of a look; its own range limits replace the lidar's.
        grid: of the lidar; each of its beams takes the nearest of the scan.
        lidar: of the scenario, with all its fields.
        place: where the lidar stood, in the world.
        workspace: of the scenario; None: every return within range counts.
    """
    near = scan.range_min if scan.range_min is not None else lidar.range_min or 0.0
    far = scan.range_max if scan.range_max is not None else lidar.range_max or math.inf
    ranges: list[float | None] = []
    missing = 0
    for index, value in enumerate(on_grid([laser_scan(scan, grid)], grid).ranges):
        bearing = place.yaw_rad + grid.angle_min + index * grid.angle_increment
        enters, leaves = (0.0, math.inf) if workspace is None else crossing(workspace, place, bearing)
        lost = math.isnan(value) or (value == 0.0 and lidar.zero == "missing") or 0.0 < value < near
        nothing = value == 0.0 or value > far or value > leaves or enters > leaves
        missing += lost or (not nothing and value < enters)
        ranges.append(None if lost or nothing or value < enters else value)
    return MeasuredBeams(ranges, missing)
