"""Repairs of lidars that are mirrored or turned, by where the mistake is."""

from datetime import UTC, datetime
from typing import Any

import pytest

from voa_client import RobotScan, Scan
from voa_console.robots.readings import AS_MEASURED, MIRRORED, TURNED
from voa_console.robots.repairs import repair
from voa_msgs.geometry import UncertainSensorPose

POSE = UncertainSensorPose(x=0.3, y=0.0, yaw_rad=3.0)


def scan(source: Any = "ros2", sensor: str | None = None) -> RobotScan:
    pose = POSE if sensor is None else None
    at = datetime(2026, 1, 2, tzinfo=UTC)
    return RobotScan(
        robot="r", session=None, source=source, at=at, sensor=sensor, sensor_pose=pose, scan=Scan(ranges=[0.5])
    )


def test_a_scan_that_is_right_needs_none() -> None:
    assert repair(AS_MEASURED, scan()) is None


@pytest.mark.parametrize(
    ("degrees", "line"), [(90, "1.5708"), (180, "3.1416"), (270, "-1.5708")], ids=["90", "180", "270"]
)
def test_a_turned_lidar_of_a_mapped_robot_has_its_line(degrees: int, line: str) -> None:
    (turned,) = [reading for reading in TURNED if reading.turned_degrees == degrees]
    proposed = repair(turned, scan())
    assert proposed is not None
    assert proposed.line == f"lidar = {{ yaw_rad = {line} }}"
    assert 'name = "r"' in proposed.words


def test_a_mirrored_lidar_of_a_mapped_robot_has_its_line_wherever_it_stands() -> None:
    for given in (scan(), scan(sensor="E")):
        proposed = repair(MIRRORED, given)
        assert proposed is not None
        assert proposed.line == "lidar = { upside_down = true }"


def test_what_is_not_in_the_mapping_is_repaired_elsewhere() -> None:
    by_name, by_program, mirrored = (
        repair(TURNED[0], scan(sensor="E")),
        repair(TURNED[0], scan("scan")),
        repair(MIRRORED, scan("scan")),
    )
    assert by_name is not None
    assert by_program is not None
    assert mirrored is not None
    assert (by_name.line, by_program.line, mirrored.line) == (None, None, None)
    assert "At sensor 'E', turn the lidar by 90° clockwise" in by_name.words
    assert "add 1.5708 (+90°) to yaw_rad of sensor_pose" in by_program.words
    assert "count counter-clockwise" in mirrored.words
