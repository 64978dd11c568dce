"""The newest scan of each robot is kept, of a bounded number of robots, and converted on request."""

from datetime import UTC, datetime, timedelta

import pytest

from tests.support.serving import scan_of
from tests.voa_ros.ros_messages import scan
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.sessions import ScanRequest
from voa_ros.pipeline import SeenScan as DecodedScan
from voa_service.usecases import seen_scans as module
from voa_service.usecases.seen_scans import SeenScans, of_decoded, of_request

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
REQUEST = ScanRequest.model_validate(scan_of([0.5, None]))
POSE = UncertainSensorPose(x=0.3, y=0.0, yaw_rad=3.0)


def test_the_newest_scan_of_a_robot_replaces_the_one_before() -> None:
    scans = SeenScans()
    assert scans.newest("r") is None
    for minute in range(2):
        scans.keep("r", "scan", of_request(REQUEST, NOON + timedelta(minutes=minute), "S"))
    assert scans.newest("r") == ("scan", scans.get("r", "scan"))
    scans.keep("r", "ros2", of_decoded(DecodedScan(scan(0.25, 0.5), POSE), NOON + timedelta(seconds=1), None))
    newest = scans.newest("r")
    assert newest is not None
    assert (newest[0], newest[1].at, newest[1].sensor) == ("scan", NOON + timedelta(minutes=1), "Q1")
    scans.drop("r", "scan")
    newest = scans.newest("r")
    assert newest is not None
    assert (newest[0], newest[1].sensor, newest[1].sensor_pose) == ("ros2", None, POSE)
    assert newest[1].message().ranges == [0.25, 0.5]


@pytest.mark.parametrize(("where", "sensor"), [("Q2", "Q2"), (None, None)])
def test_a_scan_may_have_a_name_for_its_place_or_none(where: str | None, sensor: str | None) -> None:
    seen = of_decoded(DecodedScan(scan(0.5), where), NOON, None)
    assert (seen.sensor, seen.sensor_pose) == (sensor, None)


def test_the_robot_that_was_silent_for_longest_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST", 2)
    scans = SeenScans()
    for name in ("a", "b", "a", "c"):
        scans.keep(name, "scan", of_request(REQUEST, NOON, "S"))
    assert [name for name in "abc" if scans.newest(name) is not None] == ["a", "c"]
