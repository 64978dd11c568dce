import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.standing_robots import GRID, Standing, facing, messages, robot_of, write
from tests.voa_setup.calibration.calibrations import bracket, mapping, scene_of
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_ros.motions import Motion
from voa_setup.calibration.known_object import InvalidCalibration
from voa_setup.calibration.stops import Stop, stops_of

ORIGIN, MOUNT = Motion(1.0, 0.0, 0.5), Motion(0.0, 0.0, 0.0)


def taken(folder: Path, revolutions: tuple[int, ...], place: str | None = None) -> list[Stop]:
    bench = bracket()
    stops = []
    for index, count in enumerate(revolutions):
        lidar = facing(0.5 * index, 0.4)
        stops.append(Standing(lidar, robot_of(lidar, MOUNT, ORIGIN), "as made", count))
    file = write(folder / "run.mcap", messages(bench, stops, np.random.default_rng(0)))
    own = mapping() if place is None else mapping(place)
    scene = scene_of(bench)
    return stops_of(Recording(file, RosTypes()), own, scene.at("as made", None), scene.grid)


def test_a_stop_has_the_robots_pose_by_odometry_and_its_scans(tmp_path: Path) -> None:
    stops = taken(tmp_path, (6, 2, 4))
    assert [len(stop.scans) for stop in stops] == [6, 4]
    there = robot_of(facing(1.0, 0.4), MOUNT, ORIGIN)
    np.testing.assert_allclose(stops[1].robot, [there.x, there.y, there.yaw_rad], atol=1e-6)


def test_the_scan_of_an_upside_down_lidar_is_mirrored(tmp_path: Path) -> None:
    [stop] = taken(tmp_path, (5,))
    upright, hanging = (stop.measured(upside_down_lidar=hangs) for hangs in (False, True))
    assert hanging.grid.angle_min == pytest.approx(-(GRID.beams - 1) * math.radians(1.0), abs=1e-5)
    np.testing.assert_array_equal(hanging.ranges, upright.ranges[::-1])


def test_a_robot_without_odometry_or_without_a_stop_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidCalibration, match="expected odometry or amcl"):
        taken(tmp_path, (5,), 'place = { from = "sensor", sensor = "Q1" }')
    with pytest.raises(InvalidCalibration, match="never stands still for 3 revolutions"):
        taken(tmp_path, (2, 2))
