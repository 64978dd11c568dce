"""Scans of a mapped topic: whatever keeps them from being used, and how their beams are laid out."""

import math
from collections.abc import Sequence
from itertools import pairwise

from voa_cli.doctor.findings import Finding
from voa_recordings.limits import BEAMS
from voa_ros.grids import BeamGrid, same_grid
from voa_ros.messages import LaserScan, header_contradiction
from voa_ros.robots import RobotMapping
from voa_ros.segments import SegmentJoiner

_WHOLE_TURN = BeamGrid(360, -math.pi, math.tau / 360)


def unusable(check: str, robot: RobotMapping, scans: Sequence[LaserScan], most_beams: int) -> Finding | None:
    """Find whatever keeps scans from being used; None: nothing.

    Args:
        check: name of the line.
        robot: whose scans they are.
        scans: in the order in which they came, of all frames, at least one.
        most_beams: scans with more are refused.
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
        seen = f"scans of {len(frames)} frames come on this topic: {listed}; they are refused"
        return Finding(check, "wrong", seen, f'say in the mapping which are used, such as frame_id = "{frames[0]}"')
    if robot.frame_id is not None and robot.frame_id not in frames:
        seen = f"all scans are of frame {listed}, and the mapping says {robot.frame_id!r}"
        return Finding(check, "wrong", seen, "correct frame_id in the mapping, or leave it out")
    return None


def _blind(check: str, scans: Sequence[LaserScan]) -> Finding | None:
    """Find that no beam of any scan measured anything."""
    if any(0.0 < value < math.inf for scan in scans for value in scan.ranges):
        return None
    seen = f"no beam of {len(scans)} scans measures a distance: all are 0, inf or NaN"
    return Finding(check, "wrong", seen, "does the lidar turn? is it covered, or its cable loose?")


def layout(scans: Sequence[LaserScan]) -> str:
    """Say how many beams scans have, and whether they differ from scan to scan; at least one scan."""
    counts = {len(scan.ranges) for scan in scans}
    least, most = min(counts), max(counts)
    beams = f"{most} beams" if least == most else f"{least} to {most} beams"
    if in_segments(scans):
        return f"segments of {beams}, gathered into turns"
    return beams if all(same_grid(one, other) for one, other in pairwise(scans)) else f"{beams}, irregular"


def in_segments(scans: Sequence[LaserScan]) -> bool:
    """Whether scans are segments of turns, as a picoScan sends them."""
    gatherer = SegmentJoiner[None](_WHOLE_TURN)
    return any(gatherer.receive(scan, None, 0.0) is None for scan in scans)
