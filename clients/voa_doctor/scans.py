"""Checks of a mapped topic's scans: reasons why they cannot be used, and the layout of their beams."""

import math
from collections.abc import Sequence
from itertools import pairwise

from voa_doctor.findings import Finding
from voa_recordings.limits import BEAMS
from voa_ros.grids import BeamGrid, same_grid
from voa_ros.messages import LaserScan, header_contradiction
from voa_ros.robots import RobotMapping
from voa_ros.segments import SegmentJoiner

_WHOLE_TURN = BeamGrid(360, -math.pi, math.tau / 360)


def unusable(check: str, robot: RobotMapping, scans: Sequence[LaserScan], most_beams: int) -> Finding | None:
    """Find a reason why scans cannot be used; None: there is none.

    Args:
        check: name of the check.
        robot: the mapping of the robot.
        scans: of all frames, in order of receipt, at least one.
        most_beams: largest number of beams that the service accepts.
    """
    beams = max(len(scan.ranges) for scan in scans)
    if beams > most_beams:
        seen = f"scans of {beams} beams: at most {most_beams} are allowed"
        return Finding(check, "wrong", seen, f"set {BEAMS}={beams} for `voa serve`, and for this command")
    wrong = next((why for scan in scans if (why := header_contradiction(scan)) is not None), None)
    if wrong is not None:
        return Finding(check, "wrong", wrong, "correct the driver's settings: scans with such a header are refused")
    return _wrong_frame(check, robot, scans) or _blind(check, scans)


def _wrong_frame(check: str, robot: RobotMapping, scans: Sequence[LaserScan]) -> Finding | None:
    frames = sorted({scan.frame_id for scan in scans})
    listed = ", ".join(map(repr, frames))
    if robot.frame_id is None and len(frames) > 1:
        seen = f"this topic has scans of {len(frames)} frames: {listed}; they are refused"
        return Finding(check, "wrong", seen, f'choose one in the mapping, such as frame_id = "{frames[0]}"')
    if robot.frame_id is not None and robot.frame_id not in frames:
        seen = f"all scans are of frame {listed}, and the mapping says {robot.frame_id!r}"
        return Finding(check, "wrong", seen, "correct frame_id in the mapping, or leave it out")
    return None


def _blind(check: str, scans: Sequence[LaserScan]) -> Finding | None:
    """Find that no beam of any scan measured a distance."""
    if any(0.0 < value < math.inf for scan in scans for value in scan.ranges):
        return None
    seen = f"no beam of {len(scans)} scans measures a distance: all are 0, inf or NaN"
    return Finding(check, "wrong", seen, "check that the lidar turns, is not covered, and its cable is not loose")


def layout(scans: Sequence[LaserScan]) -> str:
    """Describe the number of beams of scans, and its changes from scan to scan; at least one scan is needed."""
    counts = {len(scan.ranges) for scan in scans}
    least, most = min(counts), max(counts)
    beams = f"{most} beams" if least == most else f"{least} to {most} beams"
    if in_segments(scans):
        return f"segments of {beams}, gathered into turns"
    return beams if all(same_grid(one, other) for one, other in pairwise(scans)) else f"{beams}, irregular"


def in_segments(scans: Sequence[LaserScan]) -> bool:
    """True if scans are segments of revolutions, as a picoScan sends them."""
    gatherer = SegmentJoiner[None](_WHOLE_TURN)
    return any(gatherer.receive(scan, None, 0.0) is None for scan in scans)
