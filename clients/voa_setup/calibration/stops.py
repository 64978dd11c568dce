"""Stops of a robot in a recording: where its odometry says that it stood, and the scans of that time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.lidars import BeamGrid as CoreGrid
from voa_msgs.geometry import UncertainSensorPose
from voa_recordings.files.reading import Recording
from voa_recordings.limits import most_beams
from voa_recordings.robot_looks import RobotLooks, raise_without_scans
from voa_ros.grids import BeamGrid, upside_down
from voa_ros.messages import LaserScan
from voa_ros.motions import within
from voa_ros.robot_places import AmclPlace, Mount, OdometryPlace, PlanarPose
from voa_ros.robots import LookRule, RobotMapping
from voa_ros.scans import laser_scan, median_scan
from voa_setup.calibration.known_object import InvalidCalibration, KnownObject
from voa_setup.calibration.planar import Floats

_FEWEST = 3
"""Fewest revolutions of a stop."""
_MOST = 100
"""Most revolutions of a stop that are used."""
_NEAR_M = 1.0
_OF_DIFFERENCE = 1.0 / (0.6745 * 2.0**0.5)
"""Standard deviation of a value, by the median of the absolute differences of two."""
_FEWEST_DIFFERENCES = 20


@dataclass(frozen=True, eq=False)
class Stop:
    """A stop of the robot in front of a known object.

    Attributes:
        target: the object at its pose.
        robot: (3,) pose of the robot in the frame of its odometry or map.
        scans: revolutions, as the lidar gave them.
        grid: beams of the scenario's lidar, for revolutions whose beams differ.
    """

    target: KnownObject
    robot: Floats
    scans: tuple[LaserScan, ...]
    grid: BeamGrid

    @property
    def noise_m(self) -> float | None:
        """Standard deviation of one range near the robot, metres, by successive revolutions; None: not known."""
        rows = [scan.ranges for scan in self.scans]
        if len({len(row) for row in rows}) != 1:
            return None
        ranges = np.array(rows, dtype=np.float64)
        near = (ranges[1:] > 0.0) & (ranges[1:] < _NEAR_M) & (ranges[:-1] > 0.0) & (ranges[:-1] < _NEAR_M)
        off = np.abs(ranges[1:][near] - ranges[:-1][near])
        return float(np.median(off)) * _OF_DIFFERENCE if len(off) >= _FEWEST_DIFFERENCES else None

    def measured(self, *, upside_down_lidar: bool, part: slice = slice(None)) -> "Measured":
        """Return the median of the revolutions, beam by beam.

        Args:
            upside_down_lidar: mirror the scan, as that of a lidar that hangs upside down.
            part: of the revolutions.
        """
        scan = median_scan(self.scans[part], self.grid)
        scan = upside_down(scan) if upside_down_lidar else scan
        grid = CoreGrid(len(scan.ranges), scan.angle_min, scan.angle_increment)
        ranges = np.array(scan.ranges, dtype=np.float64)
        ranges[ranges <= 0.0] = np.nan
        return Measured(self.target, grid, ranges)


@dataclass(frozen=True, eq=False)
class Measured:
    """Ranges (r,) of one stop, metres: inf for a no-return, NaN for a missing beam; with the object and the beams."""

    target: KnownObject
    grid: CoreGrid
    ranges: Floats


def stops_of(recording: Recording, mapping: RobotMapping, target: KnownObject, grid: CoreGrid) -> list[Stop]:
    """Take the stops of a robot from a recording: at least three revolutions while its odometry stands still.

    Raises:
        InvalidCalibration: the mapping has no odometry, or the robot never stands still.
        UnreadableRecording: the recording cannot be read, or has no scans of the robot.
    """
    if not isinstance(mapping.place, OdometryPlace | AmclPlace):
        raise InvalidCalibration(
            f"robot {mapping.name!r}: place.from: expected odometry or amcl, because a calibration relates the "
            "pose of the robot in that frame to the world"
        )
    beams = BeamGrid(grid.beams, grid.angle_min, grid.angle_increment)
    place = mapping.place.model_copy(update={"origin": PlanarPose(), "std": None})
    bare = {"place": place, "lidar": Mount(), "look": LookRule(mode="every")}
    robot = RobotLooks(mapping.model_copy(update=bare), beams, most_beams())
    standing = list(_standing(_revolutions(recording, robot, beams), mapping.look))
    raise_without_scans([robot], recording)
    stops = [
        Stop(target, _mean([pose for pose, _ in group]), tuple(scan for _, scan in group[:_MOST]), beams)
        for group in standing
        if len(group) >= _FEWEST
    ]
    if not stops:
        why = "" if robot.unreadable is None else f" ({robot.unreadable})"
        raise InvalidCalibration(
            f"robot {mapping.name!r} never stands still for {_FEWEST} revolutions in the recording{why}: record a stop "
            "of a few seconds in front of the object"
        )
    return stops


Revolution = tuple[UncertainSensorPose, LaserScan]
"""Pose of the robot by its odometry, and the scan."""


def _revolutions(recording: Recording, robot: RobotLooks, grid: BeamGrid) -> Iterator[Revolution]:
    for message in recording.messages():
        taken = robot.receive(message)
        if taken is not None and taken.request.sensor_pose is not None:
            yield taken.request.sensor_pose, laser_scan(taken.request.scan, grid)


def _standing(revolutions: Iterator[Revolution], rule: LookRule) -> Iterator[list[Revolution]]:
    """Group successive revolutions for which the robot stands still."""
    group: list[Revolution] = []
    for revolution in revolutions:
        if group and not within(revolution[0], group[0][0], rule.still_xy_m, rule.still_yaw_rad):
            yield group
            group = []
        group.append(revolution)
    if group:
        yield group


def _mean(poses: Sequence[UncertainSensorPose]) -> Floats:
    """Mean of poses that are close together, (3,)."""
    rows = np.array([[pose.x, pose.y, pose.yaw_rad] for pose in poses])
    turned = np.remainder(rows[:, 2] - rows[0, 2] + np.pi, 2.0 * np.pi) - np.pi
    return np.array([rows[:, 0].mean(), rows[:, 1].mean(), rows[0, 2] + turned.mean()])
