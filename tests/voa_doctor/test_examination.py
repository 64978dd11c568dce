"""All checks in order: every failure is made for real, and its finding says what it is and what to do."""

import socket

import pytest

from tests.voa_cli.labs import Lab
from tests.voa_doctor.examinations import examined, free_port, wrong
from voa_doctor.examination import examine


def test_a_service_in_order_is_healthy(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url, "--zenoh", lab.endpoint)
    assert (code, wrong(result)) == (0, {})
    checks = [
        "HTTP",
        "service",
        "ready",
        "software",
        "messages",
        "memory",
        "clock",
        "router",
        "zenoh session",
        "replicas",
    ]
    assert [*checks, "asking", "HTTP and Zenoh", "shared memory"] == [name for name in result if "robot" not in name]
    assert result["clock"]["state"] == "ok"
    assert result["HTTP and Zenoh"]["seen"] == "the same service"


def test_a_service_on_zenoh_whose_router_is_not_named_says_so(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url)
    assert code == 0
    assert result["zenoh"]["state"] == "warning"
    assert "--zenoh" in result["zenoh"]["advice"]


def test_a_service_that_is_down(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", f"http://127.0.0.1:{free_port()}", "--zenoh", lab.endpoint)
    assert code == 1
    assert list(wrong(result)) == ["HTTP"]
    assert "nothing listens at 127.0.0.1:" in result["HTTP"]["seen"]


def test_a_name_that_nobody_has(capsys: pytest.CaptureFixture[str]) -> None:
    code, result = examined(capsys, "--url", "http://no-such-host.invalid:8000")
    assert code == 1
    assert "no such host: no-such-host.invalid" in result["HTTP"]["seen"]


def test_something_that_takes_connections_and_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        where = ["--url", f"http://127.0.0.1:{port}", "--zenoh", f"tcp/127.0.0.1:{port}"]
        code, result = examined(capsys, *where)
    assert code == 1
    assert result["service"]["seen"] == "accepts connections and does not answer"
    assert result["zenoh session"]["seen"] == "accepts connections and does not answer"


def test_findings_without_the_command_are_those_of_the_command(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    _, result = examined(capsys, "--url", lab.url)
    findings = examine(lab.url)
    assert [finding.check for finding in findings] == list(result)
    assert [finding.state for finding in findings] == [finding["state"] for finding in result.values()]
