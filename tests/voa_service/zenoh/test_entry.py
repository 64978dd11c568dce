"""The service on Zenoh, through a real router process, as a stranger sees it."""

import json
import math
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tests.support.bus import Problem, Sample, Silence, Stranger, bridged, stranger
from tests.support.routers import Router, router
from tests.support.serving import Json, Service, data_scenario, scan_of, serving
from tests.support.waiting import wait_for
from tests.voa_ros.ros_messages import odometry
from tests.voa_service.zenoh.ros_lab import laser_scan
from tests.voa_service.zenoh.test_replicas import MAPPING
from voa_ros.cdr import encode_odometry
from voa_service.failures import Failure
from voa_service.settings import Limits

GOOD = scan_of([0.5, 0.5, None, 1.0])


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, own_router: Router) -> Iterator[Service]:
    limits = Limits(scan_bytes=20_000, body_bytes=1_000_000)
    with serving(tmp_path_factory.mktemp("bus"), limits=limits) as own, bridged(own, own_router):
        yield own


@pytest.fixture
def bus(own_router: Router, service: Service) -> Iterator[Stranger]:
    with stranger(own_router.endpoint) as own:
        wait_for(lambda: own.replies("service.health", {}), "the service")
        yield own


@pytest.fixture
def session(service: Service, data_id: str) -> str:
    return service.open(data_id)


def version(service: Service, session: str) -> int:
    return int(service.get(f"/v1/sessions/{session}")["version"])


def report(service: Service, robot: str) -> Json:
    reports = [each for each in service.get("/v1/robots")["items"] if each["robot"] == robot]
    return dict(reports[0]) if reports else {"refused": 0, "session": None}


def test_a_session_from_beginning_to_end(bus: Stranger, service: Service) -> None:
    scenario = bus.call("scenario.create", data_scenario())["id"]
    assert scenario in [each["id"] for each in bus.call("scenario.list", {})["items"]]
    assert bus.call("scenario.get", {"id": scenario}) == service.get(f"/v1/scenarios/{scenario}")
    opened = bus.call("session.create", {"scenario": scenario}, id="open")
    assert bus.call("session.create", {"scenario": scenario}, id="open") == opened
    named = {"session": opened["id"]}
    looked = bus.call("voa.rank", named | {"outcomes": True})["recommendation"]
    assert looked["action"] == "look"
    after = bus.call("scan.apply", named | GOOD, id="scan")
    assert (after["version"], after["update"]["accepted"]) == (1, True)
    assert bus.call("outcome.report", named | {"grasp": "G1", "success": False})["version"] == 2
    assert bus.call("belief.put", named | {"belief": None})["belief"] == opened["belief"]
    grasps = bus.call("grasp.rank", named | {"grasps": ["G2"]})
    assert [grasp["name"] for grasp in grasps["grasps"]] == ["G2"]
    history = bus.call("history.get", named | {"limit": 2})
    assert [entry["kind"] for entry in history["items"]] == ["prior", "scan"]
    assert history["items"][1]["request"] == GOOD
    assert bus.call("session.get", named) == service.get(f"/v1/sessions/{opened['id']}")
    assert bus.call("session.delete", named) == {}
    with pytest.raises(Problem) as gone:
        bus.call("session.get", named)
    assert gone.value.kind == "not-found"


def test_answers_carry_the_version_of_messages_and_session(bus: Stranger, session: str) -> None:
    (reply,) = bus.replies("session.get", {"session": session})
    assert reply.ok is not None
    assert str(reply.ok.encoding) == "application/json"
    assert reply.ok.attachment is not None
    assert json.loads(reply.ok.attachment.to_bytes()) == {"wire": 1, "version": 0}


def test_the_service_says_that_it_is_connected(bus: Stranger, service: Service) -> None:
    health = bus.call("service.health")
    assert health["zenoh"] == "connected"
    assert service.get("/readyz")["replica"] == health["replica"]
    alive = [str(reply.ok.key_expr) for reply in bus.session.liveliness().get(bus.keys.replica("*")) if reply.ok]
    assert alive == [bus.keys.replica(health["replica"])]


def test_every_commit_is_published_whoever_made_it(bus: Stranger, service: Service, data_id: str) -> None:
    received = bus.subscribe(bus.keys.belief("*"))
    session = service.open(data_id)
    service.post(f"/v1/sessions/{session}/scans", GOOD)  # over HTTP
    bus.call("scan.apply", {"session": session} | GOOD)
    bus.put_scan(session, GOOD)
    wait_for(lambda: len(received) == 4, "four versions")
    bus.call("session.delete", {"session": session})
    wait_for(lambda: len(received) == 5, "the end")
    assert {sample.key for sample in received} == {bus.keys.belief(session)}
    assert [sample.attachment for sample in received[:4]] == [b"0", b"1", b"2", b"3"]
    assert [sample.json["version"] for sample in received[:4]] == [0, 1, 2, 3]
    assert set(received[1].json) == set(service.get(f"/v1/sessions/{service.open(data_id)}"))
    assert received[4].deleted


def test_what_changes_nothing_is_not_published(bus: Stranger, service: Service, session: str) -> None:
    received = bus.subscribe(bus.keys.belief(session))
    nothing = bus.call("scan.apply", {"session": session} | scan_of([None] * 4))
    assert nothing["update"]["reason"] == "no_beams"
    first = bus.call("scan.apply", {"session": session} | GOOD, id="k")
    assert bus.call("scan.apply", {"session": session} | GOOD, id="k") == first
    bus.call("belief.put", {"session": session, "belief": None})
    wait_for(lambda: [sample.attachment for sample in received][-1:] == [b"2"], "the second commit")
    assert [sample.attachment for sample in received if sample.attachment != b"0"] == [b"1", b"2"]  # 0 may come late


def test_scans_that_are_put_are_applied_in_order_each_once(bus: Stranger, service: Service, session: str) -> None:
    for number in range(50):
        bus.put_scan(session, scan_of(GOOD["scan"]["ranges"], stamp=number))
    wait_for(lambda: version(service, session) == 50, "fifty scans")
    history = service.get(f"/v1/sessions/{session}/history")["items"]
    assert [entry["request"]["scan"]["stamp"] for entry in history[1:]] == list(range(50))


def test_a_scan_that_is_put_twice_under_one_name_counts_once(bus: Stranger, service: Service, session: str) -> None:
    bus.put_scan(session, GOOD, id="one")
    bus.put_scan(session, GOOD, id="one")
    bus.put_scan(session, GOOD, id="two")
    wait_for(lambda: version(service, session) == 2, "two scans")
    wait_for(lambda: report(service, "r1")["session"] == session, "the report")
    assert bus.call("scan.apply", {"session": session} | GOOD, id="one")["version"] == 1


def test_the_place_of_a_scan_may_stand_beside_it(bus: Stranger, service: Service, session: str) -> None:
    bus.put_scan(session, {"scan": GOOD["scan"]}, sensor="Q2")
    wait_for(lambda: version(service, session) == 1, "the scan")
    assert service.get(f"/v1/sessions/{session}/history")["items"][1]["request"]["sensor"] == "Q2"


@pytest.mark.parametrize(
    ("name", "payload", "kind"),
    [
        ("cut", b'{"sensor": "Q1", "sc', "malformed-json"),
        ("empty", b"{}", "invalid-request"),
        ("of-another-type", b"[1, 2]", "invalid-request"),
        ("oversized", b'{"sensor": "' + b"a" * 20_000, "too-large"),
        ("without-a-place", json.dumps({"scan": GOOD["scan"]}).encode(), "invalid-request"),
        ("of-an-unknown-sensor", json.dumps(scan_of([0.5] * 4, "Q9")).encode(), "unknown-name"),
        ("of-another-grid", json.dumps(scan_of([0.5] * 9)).encode(), "beam-grid-mismatch"),
    ],
)
def test_a_scan_that_cannot_be_used_is_seen(
    bus: Stranger, service: Service, session: str, name: str, payload: bytes, kind: str
) -> None:
    received = bus.subscribe(bus.keys.refused("*", "*"))
    wait_for(lambda: _is_subscribed(bus, received), "the subscription")
    bus.session.put(bus.keys.scan(session, name), payload, encoding="application/json")
    wait_for(lambda: report(service, name)["refused"] == 1, "the refusal")
    assert report(service, name)["last_refusal"].startswith(f"{kind}: ")
    problems = wait_for(
        lambda: [each for each in received if each.key == bus.keys.refused(session, name)], "the problem"
    )
    assert problems[0].json["type"] == f"urn:voa:problem:{kind}"
    assert f'event="scan refused: {kind}"' in service.http.get("/metrics").text
    assert version(service, session) == 0
    is_scan = name in ("of-an-unknown-sensor", "of-another-grid")
    assert service.http.get(f"/v1/robots/{name}/scan").status_code == (200 if is_scan else 404)
    assert [each["reason"] for each in report(service, name)["refusals"]] == [report(service, name)["last_refusal"]]


@pytest.mark.parametrize("encoding", ["application/cdr", "application/cdr;nav_msgs/msg/Odometry"])
def test_cdr_of_another_type_is_refused_with_both_types(
    bus: Stranger, service: Service, session: str, encoding: str
) -> None:
    received = bus.subscribe(bus.keys.refused("*", "*"))
    wait_for(lambda: _is_subscribed(bus, received), "the subscription")
    bus.session.put(bus.keys.scan(session, "foreign"), encode_odometry(odometry(0.0, 0.0, 0.0)), encoding=encoding)
    problems = wait_for(
        lambda: [each for each in received if each.key == bus.keys.refused(session, "foreign")], "the problem"
    )
    assert "expected a sensor_msgs/msg/LaserScan, found a nav_msgs/msg/Odometry" in problems[0].json["detail"]
    assert version(service, session) == 0


def test_a_scan_for_a_session_that_is_not_there_is_seen(bus: Stranger, service: Service) -> None:
    bus.put_scan("nowhere", GOOD, robot="lost")
    wait_for(lambda: report(service, "lost")["refused"] == 1, "the refusal")
    assert report(service, "lost")["last_refusal"].startswith("not-found: ")


def test_one_query_more_than_fits_is_answered_overloaded(service: Service, bus: Stranger) -> None:
    gate = threading.Event()
    held: list[Future[bool]] = []
    with suppress(Failure):
        while True:  # until it is full
            held.append(service.inside.heavy.submit(lambda: gate.wait(30)))
    try:
        with pytest.raises(Problem) as refused:
            bus.call("voa.rank", {"session": "any"})
        assert refused.value.kind == "overloaded"
        assert refused.value.document["retry_after_s"] >= 1
        assert bus.call("service.health")["status"] == "ready"
    finally:
        gate.set()
    assert all(call.result(30) for call in held)


def test_a_payload_that_is_too_large_is_not_even_read(service: Service, bus: Stranger) -> None:
    most = service.inside.limits.body_bytes
    replies = list(bus.session.get(bus.keys.rpc("scan.apply"), payload=b" " * (most + 1), timeout=20.0))
    assert len(replies) == 1
    assert replies[0].err is not None
    problem = json.loads(replies[0].err.payload.to_bytes())
    assert problem["type"] == "urn:voa:problem:too-large"


def test_a_scan_for_nobody_in_particular_is_counted(service: Service, bus: Stranger) -> None:
    bus.session.put("**", json.dumps(GOOD))
    line = 'event="scan refused: no single session and robot"'
    wait_for(lambda: line in service.http.get("/metrics").text, "the count")


def test_another_root_is_another_lab(own_router: Router, service: Service) -> None:
    with stranger(own_router.endpoint, "voa/v1/elsewhere") as other, pytest.raises(Silence):
        other.call("service.health")


def _is_subscribed(bus: Stranger, received: list[Sample]) -> bool:
    """Whether what the service puts reaches us: shown by a scan that is refused."""
    bus.put_scan("nowhere", GOOD, robot="probe")
    return bool(received)


@pytest.mark.parametrize("source", ["scan", "LaserScan"])
def test_scans_that_were_received_are_applied_after_the_service_has_left_its_robots_to_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own_router: Router, source: str
) -> None:
    has_left = threading.Event()

    def moved(sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            has_left.set()

    with serving(tmp_path) as leaving, stranger(own_router.endpoint, "leaving") as bus:
        session = leaving.open(leaving.create(data_scenario()))
        hold_changes(leaving, monkeypatch, has_left.is_set)
        with (
            bus.session.liveliness().declare_subscriber(bus.keys.replica("*"), moved),
            bridged(leaving, own_router, robots=mapping_of(session, tmp_path), root="leaving"),
        ):
            put_three(leaving, bus, session, source)
        assert version(leaving, session) == 3


@pytest.mark.parametrize("source", ["scan", "LaserScan"])
def test_scans_that_were_received_are_applied_at_the_end_although_the_router_has_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    with serving(tmp_path) as leaving:
        session, link = leaving.open(leaving.create(data_scenario())), leaving.inside.health.link
        hold_changes(leaving, monkeypatch, lambda: link.state == "off")
        with router() as own, bridged(leaving, own, robots=mapping_of(session, tmp_path)):
            with stranger(own.endpoint) as bus:
                put_three(leaving, bus, session, source)
            own.kill()
            wait_for(lambda: link.state == "connecting", "the loss of the router")
        assert version(leaving, session) == 3


def mapping_of(session: str, folder: Path) -> Path:
    """A mapping of the robot `r1` to a session."""
    robots = folder / "robots.toml"
    robots.write_text(MAPPING.format(robot="r1", session=session, sensor="Q1"))
    return robots


def hold_changes(service: Service, monkeypatch: pytest.MonkeyPatch, until: Callable[[], bool]) -> None:
    """Make changes of sessions wait."""
    store = service.inside.sessions.store
    change = store.change

    def held(*arguments: Any, **named: Any) -> Any:
        wait_for(until, "the end of the service", 60.0)
        return change(*arguments, **named)

    monkeypatch.setattr(store, "change", held)


def put_three(service: Service, bus: Stranger, session: str, source: str) -> None:
    """Put three scans of the robot `r1`, raw or in ROS 2; returns when they were received."""
    wait_for(lambda: bus.replies("service.health", {}), "the service")
    for stamp in (100.0, 200.0, 300.0):
        if source == "scan":
            bus.put_scan(session, scan_of([0.5, 0.5, None, 1.0], stamp=stamp))
        else:
            bus.session.put("r1/scan", laser_scan((0.5, 0.5, math.inf, 1.0), stamp))
    counter = f'voa_zenoh_samples_total{{event="{source} received"}} 3.0'
    wait_for(lambda: counter in service.http.get("/metrics").text, "the robot's scans")
