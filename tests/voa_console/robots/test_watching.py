"""Findings of the examination, sorted by whom they are about."""

from voa_console.robots.watching import of_robot, of_service
from voa_doctor.findings import Finding

FINDINGS = [
    Finding("HTTP", "ok", "accepts connections"),
    Finding("zenoh", "warning", "the service uses Zenoh (connected), which was not checked", "name its router"),
    Finding("robots", "warning", "none"),
    Finding("robot a", "wrong", "silent"),
    Finding("robot a: poor-fit", "warning", "bad"),
    Finding("robot ab", "ok", "fine"),
    Finding("mapping", "wrong", "no TOML"),
]


def test_findings_about_robots_are_not_about_the_service() -> None:
    assert [finding.check for finding in of_service(FINDINGS)] == ["HTTP", "zenoh"]


def test_a_router_that_the_service_has_reached_is_no_warning() -> None:
    assert of_service(FINDINGS)[1].state == "ok"
    waiting = Finding("zenoh", "warning", "the service uses Zenoh (connecting), which was not checked", "name it")
    assert of_service([waiting]) == [waiting]


def test_findings_about_a_robot_are_its_own() -> None:
    assert [finding.check for finding in of_robot(FINDINGS, "a")] == ["scans", "poor-fit"]
    assert [finding.check for finding in of_robot(FINDINGS, "ab")] == ["scans"]
