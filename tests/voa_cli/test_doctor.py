"""`voa doctor`: every failure is made for real, and its line says what it is and what to do."""

import json
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, HTTPServer
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from tests.routers import Router, router
from tests.serving import data_scenario
from tests.voa_cli.labs import Lab, service_on
from tests.voa_cli.recordings.bags import laser_scan
from tests.waiting import wait_for
from voa_cli.doctor.findings import Budget, Finding, TookTooLong, checklist
from voa_cli.doctor.over_http import clocks
from voa_cli.doctor.robots import check_robots
from voa_cli.main import main
from voa_cli.zenoh_session import joined
from voa_client import Client
from voa_client.zenoh_address import ZenohAddress
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Keys
from voa_msgs.robots import RobotReport, Robots
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest
from voa_ros.cdr import encode_laser_scan

LIMIT_SECONDS = 20.0
"""The command promises 15; the machine may be busy."""

Findings = dict[str, dict[str, str]]


@pytest.fixture(scope="module")
def own_router() -> Iterator[Router]:
    with router() as own:
        yield own


@pytest.fixture(scope="module")
def lab(own_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with service_on(own_router, tmp_path_factory.mktemp("lab")) as service:
        yield service


def examined(capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, Findings]:
    """The exit code, and the findings by check."""
    began = time.monotonic()
    code = main(["doctor", "--json", *options])
    assert time.monotonic() - began < LIMIT_SECONDS
    told = json.loads(capsys.readouterr().out)
    found = {finding["check"]: finding for finding in told["findings"]}
    assert code == int(any(finding["state"] == "wrong" for finding in found.values()))
    assert told["healthy"] is (code == 0)
    assert all(finding["advice"] for finding in found.values() if finding["state"] != "ok")
    return code, found


def wrong(found: Findings) -> dict[str, str]:
    return {check: finding["seen"] for check, finding in found.items() if finding["state"] == "wrong"}


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])


def test_a_service_in_order_is_healthy(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, found = examined(capsys, "--url", lab.url, "--zenoh", lab.endpoint)
    assert (code, wrong(found)) == (0, {})
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
    assert [*checks, "asking", "HTTP and Zenoh", "shared memory"] == [name for name in found if "robot" not in name]
    assert found["clock"]["state"] == "ok"
    assert found["HTTP and Zenoh"]["seen"] == "the same service"


def test_a_person_reads_a_table(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    assert main(["doctor", "--url", lab.url, "--zenoh", lab.endpoint]) == 0
    out = capsys.readouterr().out
    assert "✓" in out
    assert "✗" not in out


def test_a_service_on_zenoh_whose_router_is_not_named_says_so(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, found = examined(capsys, "--url", lab.url)
    assert code == 0
    assert found["zenoh"]["state"] == "warning"
    assert "--zenoh" in found["zenoh"]["advice"]


def test_a_service_that_is_down(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, found = examined(capsys, "--url", f"http://127.0.0.1:{free_port()}", "--zenoh", lab.endpoint)
    assert code == 1
    assert list(wrong(found)) == ["HTTP"]
    assert "nothing listens at 127.0.0.1:" in found["HTTP"]["seen"]


def test_a_name_that_nobody_has(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = examined(capsys, "--url", "http://no-such-host.invalid:8000")
    assert code == 1
    assert "no such host: no-such-host.invalid" in found["HTTP"]["seen"]


def test_something_that_takes_connections_and_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        where = ["--url", f"http://127.0.0.1:{port}", "--zenoh", f"tcp/127.0.0.1:{port}"]
        code, found = examined(capsys, *where)
    assert code == 1
    assert found["service"]["seen"] == "takes connections and does not answer"
    assert found["zenoh session"]["seen"] == "takes connections and does not answer"


def test_a_router_that_is_down(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, found = examined(capsys, "--url", lab.url, "--zenoh", f"tcp/127.0.0.1:{free_port()}")
    assert (code, list(wrong(found))) == (1, ["router"])
    assert "nothing listens" in found["router"]["seen"]


def test_a_frozen_router(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    with router() as frozen:
        frozen.signal(signal.SIGSTOP)
        code, found = examined(capsys, "--url", lab.url, "--zenoh", frozen.endpoint)
        frozen.signal(signal.SIGCONT)
    assert code == 1
    assert wrong(found) == {"zenoh session": "takes connections and does not answer"}


def test_another_root(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, found = examined(capsys, "--url", lab.url, "--zenoh", f"{lab.zenoh}/voa/v1/other")
    assert code == 1
    assert wrong(found)["replicas"] == "none under voa/v1/other, but under voa/v1/default"
    assert wrong(found)["asking"] == "nobody answers at voa/v1/other/rpc/service.health"
    assert "is not seen under voa/v1/other" in wrong(found)["HTTP and Zenoh"]


def test_another_router_than_the_service_s(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    with router() as other:
        code, found = examined(capsys, "--url", lab.url, "--zenoh", other.endpoint)
    assert (code, list(wrong(found))) == (1, ["replicas", "asking", "HTTP and Zenoh"])
    assert "two routers, or two roots" in found["HTTP and Zenoh"]["advice"]
    assert "not running, or on another router or root" in found["asking"]["advice"]
    assert "access_control" in found["asking"]["advice"]


def test_a_service_without_a_router(capsys: pytest.CaptureFixture[str], process: str, own_router: Router) -> None:
    code, found = examined(capsys, "--url", process, "--zenoh", own_router.endpoint)
    assert code == 1
    assert wrong(found)["HTTP and Zenoh"] == "the service behind the URL is not told of any router"


def test_a_service_that_waits_for_its_router(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    absent = Router()
    with service_on(absent, tmp_path, joined=False) as waiting, router() as other:
        code, found = examined(capsys, "--url", waiting.url, "--zenoh", other.endpoint)
    assert code == 1
    assert wrong(found)["HTTP and Zenoh"] == "the service behind the URL has not reached its router"


@contextmanager
def guarded(folder: Path, more: dict[str, Any] | None = None) -> Iterator[Router]:
    """A router that knows two users."""
    users = folder / "users.txt"
    users.write_text("service:right\nrobot:right\n")
    known = {"transport/auth/usrpwd": {"user": "router", "password": "r", "dictionary_file": str(users)}}
    with router(known | (more or {})) as own:
        yield own


@pytest.mark.parametrize(("user", "as_whom"), [("robot:wrong@", "as 'robot'"), ("", "as nobody")])
def test_a_router_that_refuses_us(
    capsys: pytest.CaptureFixture[str], lab: Lab, tmp_path: Path, user: str, as_whom: str
) -> None:
    with guarded(tmp_path) as own:
        code, found = examined(capsys, "--url", lab.url, "--zenoh", f"zenoh://{user}127.0.0.1:{own.port}")
        right = examined(capsys, "--url", lab.url, "--zenoh", f"zenoh://robot:right@127.0.0.1:{own.port}")[1]
    assert code == 1
    assert wrong(found) == {"zenoh session": f"the router is there and refuses us {as_whom}"}
    assert right["zenoh session"]["state"] == "ok"


def test_rules_of_the_router_that_forbid_us_to_ask(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_ZENOH__USER", "service")
    monkeypatch.setenv("VOA_ZENOH__PASSWORD", "right")
    everything = [
        "put", "delete", "declare_subscriber", "query", "reply", "declare_queryable", "liveliness_token",
        "liveliness_query", "declare_liveliness_subscriber",
    ]  # fmt: skip
    seeing = ["liveliness_token", "liveliness_query", "declare_liveliness_subscriber"]
    rules = [
        {"id": "all", "permission": "allow", "messages": everything, "flows": ["ingress", "egress"]},
        {"id": "see", "permission": "allow", "messages": seeing, "flows": ["ingress", "egress"]},
    ]
    acl = {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule | {"key_exprs": ["voa/**"]} for rule in rules],
        "subjects": [{"id": name, "usernames": [name]} for name in ("service", "robot")],
        "policies": [{"rules": ["all"], "subjects": ["service"]}, {"rules": ["see"], "subjects": ["robot"]}],
    }
    with guarded(tmp_path, {"access_control": acl}) as own, service_on(own, tmp_path / "service") as lab:
        address = f"zenoh://robot:right@127.0.0.1:{own.port}"
        code, found = examined(capsys, "--url", lab.url, "--zenoh", address)
    assert code == 1
    assert list(wrong(found)) == ["asking"]
    assert "forbid this user to query" in found["asking"]["advice"]


@contextmanager
def answering(path: str, status: int, body: bytes) -> Iterator[str]:
    """An HTTP server that lives, and has one more answer."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            told = (status, body) if self.path == path else (200, b'{"status": "alive"}')
            self.send_response(told[0])
            self.send_header("Content-Length", str(len(told[1])))
            self.end_headers()
            self.wfile.write(told[1])

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - the base class's name
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


def health(**changes: Any) -> bytes:
    now = datetime.now(UTC) + timedelta(seconds=changes.pop("ahead", 0.0))
    told = {"status": "ready", "wire_version": WIRE_VERSION, "zenoh": "off", "now": now.isoformat()}
    return json.dumps(told | changes).encode()


@pytest.mark.parametrize(
    ("path", "status", "body", "check", "state", "says"),
    [
        ("/livez", 502, b"no upstream", "service", "wrong", "/livez answers 502"),
        ("/livez", 200, b"<html>", "service", "wrong", "not ours"),
        ("/readyz", 503, b"{}", "ready", "wrong", "/readyz answers 503"),
        (
            "/readyz",
            503,
            b'{"type": "urn:voa:problem:not-ready", "title": "t", "status": 503, "detail": "no store"}',
            "ready",
            "wrong",
            "no store",
        ),
        (
            "/readyz",
            200,
            {"wire_version": WIRE_VERSION + 1},
            "messages",
            "wrong",
            f"version {WIRE_VERSION + 1} there",
        ),
        ("/readyz", 200, {"version": "0.0.1"}, "software", "warning", "0.0.1 there"),
        ("/readyz", 200, {"ahead": 3600.0}, "clock", "warning", "ahead of ours"),
        ("/readyz", 200, {"ahead": -3600.0}, "clock", "warning", "behind ours"),
    ],
)
def test_what_the_service_says_of_itself(
    capsys: pytest.CaptureFixture[str],
    path: str,
    status: int,
    body: bytes | dict[str, Any],
    check: str,
    state: str,
    says: str,
) -> None:
    with answering(path, status, body if isinstance(body, bytes) else health(**body)) as url:
        _, found = examined(capsys, "--url", url)
    assert found[check]["state"] == state
    assert says in found[check]["seen"]


MAPPING = """
[[robot]]
name = "tb3_1"
session = "{session}"
place = {{ from = "sensor", sensor = "Q1" }}
"""


def test_topics_of_a_mapping(capsys: pytest.CaptureFixture[str], lab: Lab, tmp_path: Path) -> None:
    mapping = tmp_path / "robots.toml"
    mapping.write_text(MAPPING.format(session="s"))
    where = ["--url", lab.url, "--zenoh", lab.endpoint, "--robots", str(mapping), "--listen", "0.3"]
    topic = "tb3_1 /tb3_1/scan"
    code, found = examined(capsys, *where)
    assert (code, wrong(found)) == (1, {topic: "nothing within 0.3 s"})
    with joined(ZenohAddress.parse(lab.endpoint)) as robot:
        token = robot.liveliness().declare_token(
            "@ros2_lv/0/zid/1/2/MP/%/%/driver/%tb3_1%scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_x/::"
        )
        _, found = examined(capsys, *where)
        assert "though a node says that it publishes it" in found[topic]["seen"]
        mapping.write_text(MAPPING.format(session="s").replace('name = "tb3_1"', 'name = "tb3_1"\nnamespace = "other"'))
        _, found = examined(capsys, *where)
        assert "published are /tb3_1/scan" in found["tb3_1 /other/scan"]["seen"]
        mapping.write_text(MAPPING.format(session="s"))
        for payload, state, says in (
            (scan_from(0.0), "ok", "360 beams"),
            (scan_from(-60.0), "warning", "before it came"),
            (scan_from(60.0), "warning", "after it came"),
            (b"\0\1\0\0nonsense", "wrong", "expected a sensor_msgs/msg/LaserScan"),
        ):
            with publishing(lab, "tb3_1/scan", payload):
                _, found = examined(capsys, *where[:-1], "5")
            assert found[topic]["state"] == state
            assert says in found[topic]["seen"]
        del token


def test_a_topic_of_another_type_is_wrong(capsys: pytest.CaptureFixture[str], lab: Lab, tmp_path: Path) -> None:
    mapping = tmp_path / "robots.toml"
    mapping.write_text("\ufeff" + MAPPING.format(session="s"), encoding="utf-8")
    where = ["--url", lab.url, "--zenoh", lab.endpoint, "--robots", str(mapping), "--listen", "5"]
    with publishing(lab, "0/tb3_1/scan/sensor_msgs::msg::dds_::PointCloud2_/RIHS01_x", b"\0\1\0\0"):
        _, found = examined(capsys, *where)
    finding = found["tb3_1 /tb3_1/scan"]
    assert (finding["state"], finding["seen"]) == ("wrong", "found a sensor_msgs/msg/PointCloud2")
    assert "expected sensor_msgs/msg/LaserScan" in finding["advice"]


def scan_from(seconds: float) -> bytes:
    return encode_laser_scan(laser_scan([0.5] * 360, time.time_ns() + round(seconds * 1e9)))


@contextmanager
def publishing(lab: Lab, key: str, payload: bytes) -> Iterator[None]:
    """Puts it again and again for the length of a `with`."""
    ended = threading.Event()
    with joined(ZenohAddress.parse(lab.endpoint)) as robot:

        def run() -> None:
            while not ended.wait(0.05):
                robot.put(key, payload)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


def test_a_robot_whose_scans_are_refused(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    with Client(lab.url) as client, joined(ZenohAddress.parse(lab.endpoint)) as robot:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        robot.put(Keys().scan(session, "clumsy"), b'{"ranges": 3}')
        wait_for(lambda: any(each.refused for each in client.robots().items), "the service refuses it")
    code, found = examined(capsys, "--url", lab.url, "--zenoh", lab.endpoint)
    assert code == 1
    assert "1 scans, 0 looks, 1 refused" in wrong(found)["robot clumsy"]


NOW = datetime(2026, 1, 1, tzinfo=UTC)
HEARD = RobotReport(
    robot="r1", session="s1", source="ros2", key="r1/scan", last_scan_at=NOW - timedelta(seconds=0.1), scans=9, looks=1,
    refused=0, last_refusal=None, waiting_for=None,
)  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "state", "says"),
    [
        ({}, "ok", "9 scans, 1 looks, 0 refused; last scan 0.1 s ago"),
        ({"waiting_for": "the robot to stop"}, "ok", "waits for the robot to stop"),
        ({"last_scan_at": None, "scans": 0}, "wrong", "no scan yet on r1/scan"),
        ({"last_scan_at": NOW - timedelta(minutes=1)}, "warning", "60.0 s ago"),
        ({"refused": 9, "looks": 0, "last_refusal": "bad"}, "wrong", "bad"),
        ({"refused": 1, "last_refusal": "bad"}, "warning", "bad"),
        ({"session": None}, "wrong", "there is no session for it"),
    ],
)
def test_reports_of_robots(changes: dict[str, Any], state: str, says: str) -> None:
    [finding] = check_robots(Robots(items=[HEARD.model_copy(update=changes)]), NOW)
    assert finding.state == state
    assert says in finding.seen
    assert (finding.advice == "") == (state == "ok")


def test_no_robots_is_worth_a_warning() -> None:
    [finding] = check_robots(Robots(items=[]), NOW)
    assert finding.state == "warning"


def test_what_was_seen_is_printed_as_it_is_whatever_its_length() -> None:
    console = Console(width=60, record=True, file=StringIO())
    console.print(checklist([Finding("check", "wrong", "[x] " + "a" * 200, "[/y]")]))
    printed = console.export_text()
    assert (printed.count("a"), "[x]" in printed, "[/y]" in printed) == (202, True, True)


def test_a_clock_is_only_blamed_beyond_what_can_be_told() -> None:
    assert clocks("clock", 0.3, 0.25).state == "ok"
    assert clocks("clock", -0.3, 0.1).state == "warning"


def test_work_that_hangs_is_left_behind() -> None:
    with pytest.raises(TookTooLong):
        Budget(60.0).within(0.05, threading.Event().wait)
    assert Budget(60.0).within(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        Budget(60.0).within(5.0, lambda: 1 // 0)
    assert Budget(0.0).step(5.0) <= 0.05


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        (["--zenoh", "gopher://x"], 1, "gopher"),
        (["--zenoh", "tcp/x:1", "--robots", "/nowhere.toml"], 1, "/nowhere.toml"),
    ],
)
def test_options_that_make_no_sense(
    capsys: pytest.CaptureFixture[str], options: list[str], code: int, says: str
) -> None:
    assert main(["doctor", *options]) == code
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "says"),
    [(["--robots", "x.toml"], "--robots needs --zenoh"), (["--url", "zenoh://x"], "a router goes with --zenoh")],
)
def test_options_that_do_not_go_together(capsys: pytest.CaptureFixture[str], options: list[str], says: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["doctor", *options])
    assert ended.value.code == 2
    assert says in " ".join(capsys.readouterr().err.split())
