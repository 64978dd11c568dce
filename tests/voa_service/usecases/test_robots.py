"""Reports of robots stay bounded, and show the session of each robot at the time of the request."""

from datetime import UTC, datetime, timedelta
from itertools import count

import pytest

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import scan_of
from tests.voa_ros.ros_messages import scan
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_ros.pipeline import SeenScan as DecodedScan
from voa_service.failures import Failure
from voa_service.usecases import robots as module
from voa_service.usecases.robots import LookOutcome, MappedTo, Robots

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)


def test_the_robot_received_longest_ago_is_forgotten_but_none_that_is_mapped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST", 4)
    seconds = count()
    robots = Robots(lambda: NOON + timedelta(seconds=next(seconds)), lambda robot, scenario: None)
    robots.mapped("mapped", "mapped/scan", QuietRobot(), session="S")
    for name in ("a", "b", "c", "a", "d", "e"):
        robots.received(name, "scan", f"scan/S/{name}", "S")
    assert [report.robot for report in robots.reports().items] == ["a", "d", "e", "mapped"]


def test_a_flood_of_refused_scans_removes_no_robot_whose_scans_were_accepted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST", 3)
    seconds = count()
    robots = Robots(lambda: NOON + timedelta(seconds=next(seconds)), lambda robot, scenario: None)
    robots.received("own", "scan", "scan/S/own", "S")
    for name in ("a", "b", "c", "d"):
        robots.refused(name, "scan", f"scan/S/{name}", "why")
    assert [report.robot for report in robots.reports().items] == ["c", "d", "own"]


def test_a_scan_that_cannot_be_read_counts_for_its_session_and_leaves_the_newest_scan() -> None:
    robots = Robots(lambda: NOON, lambda robot, scenario: None)
    robots.put("r", "scan/A/r", "A", ScanRequest.model_validate(scan_of([0.5], "Q2")))
    robots.put("r", "scan/A/r", "A", None)
    (report,) = robots.reports().items
    assert (report.session, report.scans, report.sensor) == ("A", 2, "Q2")
    robots.put("r", "scan/B/r", "B", None)
    (report,) = robots.reports().items
    assert (report.session, report.scans, report.sensor) == ("B", 3, None), "its place is that of a scan for A"
    assert robots.scan("r").session == "A"


def test_the_session_of_a_scan_is_that_for_which_it_was_put() -> None:
    robots = Robots(lambda: NOON, lambda robot, scenario: "newer")
    request = ScanRequest.model_validate(scan_of([0.5]))
    robots.put("r", "scan/A/r", "A", request)
    robots.received("r", "scan", "scan/B/r", "B")  # by another thread, whose scan is not kept yet
    assert (robots.scan("r").session, robots.reports().items[0].session) == ("A", "B")
    robots.mapped("m", "m/scan", QuietRobot(), scenario="S")
    for session, expected in ((None, "newer"), ("A", "A")):
        robots.seen("m", DecodedScan(scan(0.5), "Q1"), session)
        assert robots.scan("m").session == expected
    assert robots.report("m").session == "newer"


def test_a_mapped_robot_s_session_is_the_current_one_whatever_was_received_before() -> None:
    sessions = {("r", "A"): "first"}
    robots = Robots(lambda: NOON, lambda robot, scenario: sessions.get((robot, scenario)))
    robots.mapped("r", "scan", QuietRobot(), scenario="A")
    robots.mapped("fixed", "scan", QuietRobot(), session="S")
    assert [report.session for report in robots.reports().items] == ["S", "first"]
    robots.received("r", "ros2", "r/scan", "first")
    sessions["r", "A"] = "second"
    assert robots.report("r").session == robots.request_look("r").session == "second"
    sessions.clear()
    assert (robots.report("r").session, robots.report("r").scans) == (None, 1)
    assert robots.report("r").waiting_for == "a scan"


def test_the_mapping_states_the_scenario_and_session_of_a_robot() -> None:
    robots = Robots(lambda: NOON, lambda robot, scenario: None)
    robots.mapped("r", "scan", QuietRobot(), scenario="A")
    assert (robots.mapped_to("r"), robots.names()) == (MappedTo("A", None), ["r"])
    robots.unmapped("r")
    assert (robots.mapped_to("r"), robots.names()) == (None, [])
    with pytest.raises(Failure, match="no mapped robot 'r'"):
        robots.report("r")


def test_what_was_on_its_way_when_a_mapping_went_makes_no_report() -> None:
    robots = Robots(lambda: NOON, lambda robot, scenario: None)
    robots.mapped("r", "scan", QuietRobot(), session="S")
    robots.unmapped("r")
    request = ScanRequest.model_validate(scan_of([0.5]))
    update = {"accepted": True, "reason": None, "log_evidence": 0.0, "fit_rmsd_mm": 1.0}
    report = UpdateReport.model_validate(update | {"fit_hit_rmsd_mm": 1.0, "best_fit_pose": "A", "beams_compared": 1})
    robots.received("r", "ros2", "scan", "S")
    robots.looked("r", "ros2", "scan", "S", request, LookOutcome(version=1, update=report))
    assert not robots.refused("r", "ros2", "scan", "why")
    assert robots.reports().items == []
