"""Keys on Zenoh, through a real router: calls and scans without a valid key have no effect, and robots see why."""

from collections.abc import Iterator

import pytest

from tests.support.api_keys import key_for
from tests.support.bus import Problem, Stranger, bridged, stranger
from tests.support.routers import router
from tests.support.serving import Service, data_scenario, scan_of, serving
from tests.support.waiting import wait_for
from voa_client import ApiKey, Client, DeniedError, OverloadedError, Retries, ZenohAddress, ZenohTransport
from voa_msgs.sessions import Scan, ScanRequest
from voa_service.rpc.methods import methods_of
from voa_service.settings import RateSettings

GOOD = scan_of([0.5, 0.5, None, 1.0])


@pytest.fixture(scope="module")
def endpoint_and_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Service]]:
    folder, rates = tmp_path_factory.mktemp("bus"), RateSettings(heavy="5/hour")
    with router() as own, serving(folder, rates=rates) as service, bridged(service, own):
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
