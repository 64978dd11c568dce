"""Keys on Zenoh, through a real router: calls and scans without a valid key have no effect, and robots see why."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest

from tests.support.api_keys import key_for
from tests.support.bus import SECONDS, Problem, Stranger, bridged, stranger
from tests.support.routers import router
from tests.support.serving import Service, data_scenario, scan_of, serving
from tests.support.waiting import wait_for
from voa_client import ApiKey, Client, DeniedError, OverloadedError, Retries, ZenohAddress, ZenohTransport
from voa_msgs.robots import RobotReport
from voa_msgs.sessions import Scan, ScanRequest
from voa_service.access.rates import Rates
from voa_service.failures import Overloaded
from voa_service.rpc.methods import methods_of
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits, RateSettings
from voa_service.zenoh.replicas import Replicas

GOOD = scan_of([0.5, 0.5, None, 1.0])
ROLES = ("sensor", "viewer")
LIMITS = Limits(scan_bytes=20_000, body_bytes=1_000_000)


@pytest.fixture(scope="module")
def endpoint_and_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Service]]:
    folder, rates = tmp_path_factory.mktemp("bus"), RateSettings(heavy="5/hour", refused="100000/second")
    with router() as own, serving(folder, rates=rates, limits=LIMITS) as service, bridged(service, own):
        yield own.endpoint, service


@pytest.fixture(scope="module")
def service(endpoint_and_service: tuple[str, Service]) -> Service:
    return endpoint_and_service[1]


@pytest.fixture(scope="module")
def sessions(service: Service) -> list[str]:
    scenario = service.create(data_scenario())
    ids = [service.open(scenario) for _ in range(2)]
    key_for(service, "operator")
    return ids


@pytest.fixture
def bus(endpoint_and_service: tuple[str, Service], sessions: list[str]) -> Iterator[Stranger]:
    with stranger(endpoint_and_service[0]) as own:
        wait_for(lambda: own.replies("service.health", {}), "the service")
        yield own


def kind_of(bus: Stranger, method: str, body: object, **beside: str) -> str:
    with pytest.raises(Problem) as refused:
        bus.call(method, body, **beside)
    return refused.value.kind


def version(service: Service, session: str) -> int:
    state = service.inside.sessions.store.get_session(session)
    assert state is not None
    return state.version


def report_on(service: Service, robot: str) -> RobotReport:
    (report,) = [each for each in service.inside.robots.reports().items if each.robot == robot]
    return report


def test_without_a_valid_key_no_method_but_health_is_answered(bus: Stranger, service: Service) -> None:
    assert bus.call("service.health")["status"] == "ready"
    for method in {*methods_of(service.inside), "scan.guess"} - {"service.health"}:
        assert kind_of(bus, method, {}) == "unauthenticated", method
        assert kind_of(bus, method, {}, key="nonsense") == "unauthenticated", method


def test_each_role_makes_its_calls(bus: Stranger, service: Service, sessions: list[str]) -> None:
    sensor, arm, viewer = (key_for(service, role) for role in ("sensor", "arm", "viewer"))
    named = {"session": sessions[0]}
    before = version(service, sessions[0])
    assert bus.call("scan.apply", named | GOOD, key=sensor)["version"] == before + 1
    assert bus.call("outcome.report", named | {"grasp": "G1", "success": False}, key=arm)["version"] == before + 2
    assert bus.call("session.get", named, key=viewer)["version"] == before + 2
    assert bus.call("caller.get", {}, key=arm)["role"] == "arm"
    for method, body, key in (
        ("scan.apply", named | GOOD, arm),
        ("outcome.report", named | {"grasp": "G1", "success": False}, sensor),
        ("belief.put", named | {"belief": None}, viewer),
        ("session.delete", named, sensor),
        ("session.create", {"scenario": "any"}, arm),
        ("scan.guess", {}, viewer),
    ):
        assert kind_of(bus, method, body, key=key) == "forbidden", method
    assert kind_of(bus, "scan.guess", {}, key=key_for(service, "operator")) == "not-found"


def test_a_bound_key_is_for_its_session_and_robot(bus: Stranger, service: Service, sessions: list[str]) -> None:
    own = key_for(service, "sensor", sessions=(sessions[0],), robots=("r1",))
    assert bus.call("session.get", {"session": sessions[0]}, key=own)["id"] == sessions[0]
    assert kind_of(bus, "scan.apply", {"session": sessions[1]} | GOOD, key=own) == "forbidden"
    assert kind_of(bus, "scan.apply", {"id": sessions[1]} | GOOD, key=own) == "forbidden"
    assert [item["id"] for item in bus.call("session.list", {}, key=own)["items"]] == [sessions[0]]
    assert kind_of(bus, "robot.look", {"robot": "r2"}, key=own) == "forbidden"
    assert kind_of(bus, "robot.scan", {"robot": "r2"}, key=own) == "forbidden"
    assert kind_of(bus, "robot.scan", {"robot": "r1"}, key=own) == "not-found"
    look = {"session": sessions[0], "sensor": "Q1", "robot": "r2"}
    assert kind_of(bus, "look.announce", look, key=own) == "forbidden"


def test_a_scan_that_is_put_without_a_valid_key_has_no_effect_and_is_reported(
    bus: Stranger, service: Service, sessions: list[str]
) -> None:
    sensor, viewer = key_for(service, "sensor"), key_for(service, "viewer")
    bound = key_for(service, "sensor", sessions=(sessions[1],), robots=("r1",))
    session, received = sessions[1], bus.subscribe(bus.keys.refused("*", "*"))

    def problem(robot: str) -> str:
        def kinds() -> list[str]:
            key = bus.keys.refused(session, robot)
            return [str(each.json["type"]).rpartition(":")[2] for each in received if each.key == key]

        return wait_for(kinds, f"the refusal of {robot}")[0]

    def is_subscribed() -> bool:
        bus.put_scan("nowhere", GOOD, robot="probe")
        return bool(received)

    wait_for(is_subscribed, "the subscription")
    before = version(service, session)
    bus.put_scan(session, GOOD, robot="nobody")
    bus.put_scan(session, GOOD, robot="guessing", key="nonsense")
    bus.put_scan(session, GOOD, robot="watching", key=viewer)
    bus.put_scan(session, GOOD, robot="another", key=bound)
    bus.put_scan(sessions[0], GOOD, robot="r1", key=bound)
    assert problem("nobody") == problem("guessing") == "unauthenticated"
    assert problem("watching") == problem("another") == "forbidden"
    wait_for(lambda: any(each.key == bus.keys.refused(sessions[0], "r1") for each in received), "the other session")
    assert version(service, session) == before
    bus.put_scan(session, GOOD, robot="r9", key=sensor)
    wait_for(lambda: version(service, session) == before + 1, "a scan with a key")
    bus.put_scan(session, GOOD, robot="r1", key=bound)
    wait_for(lambda: version(service, session) == before + 2, "a scan with a key of its own")
    assert not any(key in each.payload.decode() for each in received for key in (sensor, viewer, bound))


@pytest.mark.parametrize(
    ("why", "role", "bound", "payload"),
    [
        ("unauthenticated", None, {}, GOOD),
        ("unauthenticated", "nonsense", {}, GOOD),
        ("unauthenticated", "unreadable", {}, GOOD),
        ("forbidden", "viewer", {}, GOOD),
        ("forbidden", "sensor", {"robots": ("another",)}, GOOD),
        ("forbidden", "sensor", {"sessions": ("another",)}, GOOD),
        ("forbidden", "sensor", {"robots": ("victim",)}, GOOD),
        ("forbidden", "sensor", {"robots": ("victim",)}, b"\0" * 20_001),
        ("forbidden", "sensor", {"robots": ("victim",)}, {}),
        ("forbidden", "sensor", {"robots": ("victim",)}, b"\0nothing"),
    ],
)
def test_a_scan_that_may_not_be_put_moves_no_robot_to_another_session(
    bus: Stranger, service: Service, sessions: list[str], why: str, role: Any, bound: Any, payload: Any
) -> None:
    own, other = sessions
    robots, store = service.inside.robots, service.inside.sessions.store
    store.claim_robot("victim", own)
    before = version(service, own)
    bus.put_scan(own, GOOD, robot="victim", key=key_for(service, "sensor"))
    wait_for(lambda: version(service, own) == before + 1, "the scan")
    wait_for(lambda: report_on(service, "victim").last_look, "the report")
    accepted = report_on(service, "victim")
    attachment = json.dumps({} if role is None else {"key": key_for(service, role, **bound) if role in ROLES else role})
    bus.session.put(
        bus.keys.scan(other, "victim"),
        payload if isinstance(payload, bytes) else json.dumps(payload),
        encoding="application/cdr" if isinstance(payload, bytes) else "application/json",
        attachment="no JSON" if role == "unreadable" else attachment,
    )
    wait_for(lambda: report_on(service, "victim").refused == accepted.refused + 1, "the refusal")
    refused = report_on(service, "victim")
    assert str(refused.last_refusal).startswith(f"{why}: ")
    counts = {"refused", "last_refusal", "refusals"}
    assert refused.model_dump(exclude=counts) == accepted.model_dump(exclude=counts)
    assert robots.scan("victim").session == own
    reading, peeping = (key_for(service, "viewer", sessions=(session,)) for session in (own, other))
    assert bus.call("robot.scan", {"robot": "victim"}, key=reading)["session"] == own
    assert kind_of(bus, "robot.scan", {"robot": "victim"}, key=peeping) == "forbidden"
    for key, shown in ((reading, True), (peeping, False)):
        assert ("victim" in [each["robot"] for each in bus.call("robot.list", {}, key=key)["items"]]) is shown


def fill(queue: WorkQueue, work: Callable[[], object]) -> None:
    """Submit work until the queue takes no more."""
    with suppress(Overloaded):
        while True:
            queue.submit(work)


def test_a_call_of_a_stranger_takes_no_place_in_a_queue(bus: Stranger, service: Service, sessions: list[str]) -> None:
    viewer, release, reads = key_for(service, "viewer"), threading.Event(), service.inside.reads
    named = {"session": sessions[0]}
    try:
        fill(reads, release.wait)
        waiting = reads.inside
        assert kind_of(bus, "session.get", named, key=viewer) == "overloaded"
        assert kind_of(bus, "session.get", named) == "unauthenticated"
        assert kind_of(bus, "session.get", named, key="nonsense") == "unauthenticated"
        assert reads.inside == waiting
    finally:
        release.set()
    wait_for(lambda: reads.inside == 0, "the queue")
    assert bus.call("session.get", named, key=viewer)["id"] == sessions[0]


def test_calls_without_a_valid_key_are_limited_together_and_scans_by_robot(
    bus: Stranger, service: Service, sessions: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sensor, session = key_for(service, "sensor"), sessions[0]
    monkeypatch.setattr(service.inside.gate, "_rates", Rates("1000/second", "1000/second", "2/hour"))
    unreadable = bus.session.get(bus.keys.rpc("session.get"), attachment="no JSON", timeout=SECONDS)
    errors = [json.loads(reply.err.payload.to_bytes()) for reply in unreadable if reply.err is not None]
    assert [error["status"] for error in errors] == [401]
    assert errors[0]["detail"].startswith("no key can be read: attachment: ")
    kinds = ["unauthenticated"]
    kinds += [kind_of(bus, method, {}) for method in ("session.list", "scan.apply", "robot.list")]
    assert kinds == ["unauthenticated", "unauthenticated", "too-many-without-key", "too-many-without-key"]
    assert bus.call("session.get", {"session": session}, key=sensor)["id"] == session
    before = version(service, session)
    for attachment in (None, "no JSON", "no JSON", None, "no JSON"):
        bus.session.put(bus.keys.scan(session, "flooding"), json.dumps(GOOD), attachment=attachment)
    bus.put_scan(session, GOOD, robot="flooding", key=sensor)
    wait_for(lambda: version(service, session) == before + 1, "the scan with a key, put last")
    wait_for(lambda: report_on(service, "flooding").looks == 1, "the look to be counted, after its commit")
    report = report_on(service, "flooding")
    assert (report.scans, report.refused, report.looks) == (1, 2, 1), "five were put without a key, and two reported"


def test_a_robot_of_a_session_puts_its_scans_there_alone(bus: Stranger, service: Service, sessions: list[str]) -> None:
    own, store = key_for(service, "sensor", robots=("claimed",)), service.inside.sessions.store
    assert store.claim_robot("claimed", sessions[0])
    before = [version(service, session) for session in sessions]
    for session in reversed(sessions):
        bus.put_scan(session, GOOD, robot="claimed", key=own)
    wait_for(lambda: version(service, sessions[0]) == before[0] + 1, "the scan of its own session")
    (report,) = [each for each in service.inside.robots.reports().items if each.robot == "claimed"]
    wait_for(lambda: "which session" in str(report_on(service, "claimed").last_refusal), "the refusal")
    assert report.scans == 1
    assert version(service, sessions[1]) == before[1]
    store.claim_robot("claimed", None)
    bus.put_scan(sessions[1], GOOD, robot="claimed", key=own)
    wait_for(lambda: "which was released" in str(report_on(service, "claimed").last_refusal), "the refusal")
    assert version(service, sessions[1]) == before[1]
    store.claim_robot("claimed", sessions[1])
    bus.put_scan(sessions[1], GOOD, robot="claimed", key=own)
    wait_for(lambda: version(service, sessions[1]) == before[1] + 1, "a scan after the next claim")


def test_a_scan_that_cannot_be_read_counts_for_the_session_that_its_robot_put_it_for(
    bus: Stranger, service: Service, sessions: list[str]
) -> None:
    def refused() -> list[int]:
        return [each.refused for each in service.inside.robots.reports().items if each.robot == "unreadable"]

    key = key_for(service, "sensor", robots=("unreadable",), sessions=(sessions[0],))
    for payload in (b"\0nothing", b"\0" * 20_001):
        bus.put_scan(sessions[0], payload, robot="unreadable", key=key)
    wait_for(lambda: refused() == [2], "the refusals")
    report = report_on(service, "unreadable")
    assert (report.session, report.scans) == (sessions[0], 2)


def test_a_scan_that_another_replica_applied_before_its_robot_moved_is_not_refused(
    bus: Stranger, service: Service, sessions: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    own, store = key_for(service, "sensor", robots=("moved",)), service.inside.sessions.store
    before = version(service, sessions[0])
    bus.put_scan(sessions[0], GOOD, robot="moved", key=own, id="once")
    wait_for(lambda: version(service, sessions[0]) == before + 1, "the scan")
    store.claim_robot("moved", sessions[1])
    monkeypatch.setattr(Replicas, "owns", lambda _, name: False)
    bus.put_scan(sessions[0], GOOD, robot="moved", key=own, id="once")
    bus.put_scan(sessions[0], GOOD, robot="moved", key=own, id="another")
    wait_for(lambda: report_on(service, "moved").refused, "the refusal of the other scan, put last")
    report = report_on(service, "moved")
    assert (report.scans, report.refused, report.looks) == (2, 1, 1)
    assert version(service, sessions[0]) == before + 1


def test_a_client_sends_its_key(endpoint_and_service: tuple[str, Service], sessions: list[str]) -> None:
    endpoint, service = endpoint_and_service
    request = ScanRequest(sensor="Q1", scan=Scan(ranges=GOOD["scan"]["ranges"]))
    briefly = Retries(within_s=0.0)
    with Client(endpoint, key=key_for(service, "sensor"), retries=briefly) as client:
        assert client.apply_scan(sessions[0], request).update.accepted
        with pytest.raises(DeniedError, match="needs the role operator"):
            client.delete_session(sessions[0])
        for _ in range(5):
            client.rank_looks(sessions[0])
        with pytest.raises(OverloadedError, match="try again in") as refused:
            client.rank_looks(sessions[0])
        assert refused.value.retry_after_s is not None
    with Client(endpoint) as client, pytest.raises(DeniedError, match="VOA_KEY_FILE"):
        client.get_session(sessions[0])
    own = ZenohTransport(ZenohAddress.parse(endpoint), ApiKey(key_for(service, "viewer")))
    with Client(own) as client:
        assert client.caller().role == "viewer"
