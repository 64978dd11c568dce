"""Keys over HTTP: nothing but health without one, each role its calls, and refusals before a body is read."""

import asyncio
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any, cast

import pytest
from fastapi import FastAPI

from tests.support.api_keys import bearer, key_for, make_key, revoke_key, url_of
from tests.support.audit import audited
from tests.support.serving import Json, Service, data_scenario, scan_of, serving
from tests.support.waiting import wait_for
from tests.voa_service.access.test_roles import routes_of
from voa_msgs.callers import Role
from voa_service.access.keyring import REFRESH_SECONDS
from voa_service.settings import RateSettings

GOOD = scan_of([0.5, 0.5, None, 1.0])
HEALTH = {"/livez", "/readyz"}


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with a session, for which keys were made."""
    with serving(tmp_path_factory.mktemp("closed"), rates=RateSettings(refused="100000/second")) as service:
        scenario = service.create(data_scenario())
        for id_ in ("one", "two"):
            service.post("/v1/sessions", {"scenario": scenario}, **{"Idempotency-Key": id_})
        key_for(service, "operator")
        yield service


@pytest.fixture(scope="module")
def operator(closed: Service) -> dict[str, str]:
    return bearer(key_for(closed, "operator"))


@pytest.fixture(scope="module")
def sessions(closed: Service, operator: dict[str, str]) -> list[str]:
    return [each["id"] for each in closed.http.get("/v1/sessions", headers=operator).json()["items"]]


def kind(answer: Any) -> str:
    return str(answer.json()["type"]).rpartition(":")[2]


def test_without_a_valid_key_nothing_but_health_is_answered_on_any_route(closed: Service) -> None:
    for method, path in {*routes_of(closed), ("GET", "/nowhere"), ("TRACE", "/v1/sessions"), ("GET", "/v1/sessions/")}:
        for headers in ({}, bearer("nonsense"), {"Authorization": "Basic YTpi"}, bearer(f"voa_{'0' * 12}_{'0' * 64}")):
            answer = closed.http.request(method, path.replace("{}", "x"), headers=headers, follow_redirects=False)
            if path in HEALTH:
                assert answer.status_code == 200
                continue
            assert (answer.status_code, answer.headers["WWW-Authenticate"]) == (401, "Bearer"), (method, path)
            assert answer.headers["content-type"] == "application/problem+json"
            assert kind(answer) == "unauthenticated"


def test_an_operator_reaches_every_route(closed: Service, operator: dict[str, str]) -> None:
    for method, path in routes_of(closed):
        if not path.endswith("/events"):
            answer = closed.http.request(method, path.replace("{}", "x"), headers=operator)
            assert answer.status_code not in (401, 403, 405), (method, path)
    assert closed.http.get("/nowhere", headers=operator).status_code == 404


@pytest.mark.parametrize(
    ("role", "scan", "outcome", "belief", "look"),
    [("viewer", 403, 403, 403, 403), ("arm", 403, 200, 403, 403), ("sensor", 200, 403, 403, 201)],
)
def test_each_role_makes_its_calls(
    closed: Service, sessions: list[str], role: Role, scan: int, outcome: int, belief: int, look: int
) -> None:
    own, path = bearer(key_for(closed, role)), f"/v1/sessions/{sessions[0]}"
    http = closed.http
    for read in (path, f"{path}/history", f"{path}/voa", f"{path}/grasps", "/v1/robots", "/metrics", "/openapi.json"):
        assert http.get(read, headers=own).status_code == 200, read
    assert http.post(f"{path}/voa", json={}, headers=own).status_code == 200
    answers = {
        "scan": http.post(f"{path}/scans", json=GOOD, headers=own),
        "outcome": http.post(f"{path}/grasp-outcomes", json={"grasp": "G1", "success": False}, headers=own),
        "belief": http.put(f"{path}/belief", json={"belief": None}, headers=own),
        "look": http.post(f"{path}/looks", json={"sensor": "Q1"}, headers=own),
    }
    assert [answer.status_code for answer in answers.values()] == [scan, outcome, belief, look]
    for answer in answers.values():
        if answer.status_code == 403:
            assert kind(answer) == "forbidden"
            assert f"'{role}-1' has the role {role}" in answer.json()["detail"]
    assert http.delete(path, headers=own).status_code == 403
    assert http.get("/nowhere", headers=own).status_code == 403


def test_a_key_for_a_session_is_for_no_other(closed: Service, sessions: list[str]) -> None:
    own = bearer(key_for(closed, "sensor", sessions=(sessions[0],)))
    opening = key_for(closed, "operator", sessions=(sessions[0],))
    statuses = [closed.http.post(f"/v1/sessions/{id_}/scans", json=GOOD, headers=own).status_code for id_ in sessions]
    assert statuses == [200, 403]
    assert closed.http.get(f"/v1/sessions/{sessions[1]}", headers=own).status_code == 403
    scenario = {"scenario": closed.http.get("/v1/scenarios", headers=own).json()["items"][0]["id"]}
    assert closed.http.post("/v1/sessions", json=scenario, headers=bearer(opening)).status_code == 403
    assert closed.http.get("/v1/scenarios", headers=own).status_code == 200


def test_a_key_for_a_robot_is_for_no_other(closed: Service, sessions: list[str]) -> None:
    own, path = bearer(key_for(closed, "operator", robots=("r1",))), f"/v1/sessions/{sessions[0]}/looks"
    http = closed.http
    looks = [http.post(path, json={"sensor": "Q1"} | named, headers=own) for named in ({}, {"robot": "r1"})]
    assert [answer.status_code for answer in looks] == [403, 201]
    assert http.post(path, json={"sensor": "Q1", "robot": "r2"}, headers=own).status_code == 403
    assert http.post("/v1/robots/r2/look", headers=own).status_code == 403
    assert http.post("/v1/robots/r1/look", headers=own).status_code == 404, "no robot of this name is mapped"
    claim = {"scenario": http.get("/v1/scenarios", headers=own).json()["items"][0]["id"], "robots": ["r2"]}
    assert http.post("/v1/sessions", json=claim, headers=own).status_code == 403


@pytest.mark.parametrize("end", ["%0A", "%0D", "%00", "/", "//"])
def test_no_way_of_writing_a_path_passes_the_binding_of_a_key(
    closed: Service, sessions: list[str], operator: dict[str, str], end: str
) -> None:
    own = bearer(key_for(closed, "operator", sessions=(sessions[0],)))
    other = f"/v1/sessions/{sessions[1]}"
    before = closed.http.get(other, headers=operator).json()["version"]
    for method, path in (
        ("PUT", f"{other}/belief"),
        ("POST", f"{other}/scans"),
        ("DELETE", other),
        ("POST", "/v1/sessions"),
        ("GET", other),
    ):
        answer = closed.http.request(method, path + end, headers=own, json={"belief": None}, follow_redirects=False)
        assert answer.status_code == 403, (method, path + end)
        answer = closed.http.request(method, path + end, headers=operator, json={}, follow_redirects=False)
        assert answer.status_code in (307, 404), (method, path + end)
    assert closed.http.get(other, headers=operator).json()["version"] == before


def test_a_claim_is_for_a_session_that_the_key_is_for(closed: Service, sessions: list[str]) -> None:
    own = bearer(key_for(closed, "operator", sessions=(sessions[0],)))
    answers = [
        closed.http.put("/v1/robots/r1/session", json={"session": id_}, headers=own).status_code for id_ in sessions
    ]
    assert answers == [404, 403]


def test_the_caller_reads_what_it_may_do(closed: Service, sessions: list[str]) -> None:
    own = bearer(key_for(closed, "sensor", sessions=(sessions[0],), robots=("r1",)))
    caller = closed.http.get("/v1/caller", headers=own).json()
    assert (caller["name"], caller["role"], caller["sessions"], caller["robots"]) == (
        "sensor-1",
        "sensor",
        [sessions[0]],
        ["r1"],
    )
    assert "scan.apply" in caller["calls"]
    assert "session.delete" not in caller["calls"]


def test_a_service_without_keys_calls_everybody_anonymous(service: Service) -> None:
    caller = service.http.get("/v1/caller", headers=bearer("nonsense")).json()
    assert (caller["name"], caller["role"], caller["key"]) == ("anonymous", "operator", None)


def test_a_new_session_has_an_address_and_keys_of_requests_belong_to_the_caller(closed: Service) -> None:
    scenario = closed.http.get("/v1/scenarios", headers=bearer(key_for(closed, "viewer"))).json()["items"][0]["id"]
    own = [
        bearer(make_key(url_of(closed.database), "operator", name)) | {"Idempotency-Key": "k"}
        for name in ("a", "a", "b")
    ]
    closed.inside.gate.keyring.refresh()
    made = [closed.http.post("/v1/sessions", json={"scenario": scenario}, headers=each) for each in own]
    assert made[0].headers["Location"] == f"/v1/sessions/{made[0].json()['id']}"
    ids = [answer.json()["id"] for answer in made]
    assert ids[0] == ids[1], "a key that replaces another one of its name repeats that one's requests"
    assert ids[0] != ids[2]


def test_the_document_states_that_a_key_is_needed_once_one_exists(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        before = service.get("/openapi.json")
        key = key_for(service, "viewer")
        after = service.http.get("/openapi.json", headers=bearer(key)).json()
    documents: list[tuple[Json, list[Json]]] = [(before, [{}, {"key": []}]), (after, [{"key": []}])]
    for document, expected in documents:
        assert document["components"]["securitySchemes"]["key"]["scheme"] == "bearer"
        for path, methods in document["paths"].items():
            for operation in methods.values():
                assert operation.get("security") == (None if path in HEALTH else expected), path
                if path not in HEALTH:
                    assert {"401", "403", "429"} <= set(operation["responses"])
    scans = after["paths"]["/v1/sessions/{id}/scans"]["post"]
    assert scans["x-roles"] == ["sensor", "operator"]


def test_a_body_of_a_stranger_is_not_read(closed: Service) -> None:
    """The headers decide: the application never requests the body."""
    requested = False
    sent: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        nonlocal requested
        requested = True
        return {"type": "http.request", "body": b"x" * 1_000_000, "more_body": True}

    async def send(message: Any) -> None:
        sent.append(message)

    headers = [(b"host", b"127.0.0.1"), (b"content-length", b"20000000"), (b"content-type", b"multipart/form-data")]
    scope = {"type": "http", "method": "POST", "path": "/v1/objects", "headers": headers, "query_string": b""}
    asyncio.run(cast(FastAPI, closed.http.app)(scope, receive, send))
    assert sent[0]["status"] == 401
    assert not requested


def test_too_many_calls_are_429_with_a_time_to_wait(tmp_path: Path) -> None:
    with serving(tmp_path, rates=RateSettings(calls="3/hour")) as service:
        assert {service.http.get("/v1/lidars").status_code for _ in range(5)} == {200}, "without keys there is no rate"
        own, other = bearer(key_for(service, "viewer")), bearer(key_for(service, "arm"))
        answers = [service.http.get("/v1/lidars", headers=own) for _ in range(4)]
        assert [answer.status_code for answer in answers] == [200, 200, 200, 429]
        assert kind(answers[-1]) == "too-many-requests"
        assert 3_500 < int(answers[-1].headers["Retry-After"]) == answers[-1].json()["retry_after_s"] <= 3_600
        assert service.http.get("/v1/lidars", headers=other).status_code == 200
        assert service.http.get("/readyz", headers=own).status_code == 200


def test_a_service_that_requires_keys_answers_nothing_but_health_before_the_first_one(tmp_path: Path) -> None:
    with serving(tmp_path, require_keys=True) as service:
        http = service.http
        assert {http.get(path).status_code for path in HEALTH} == {200}
        refused = http.post("/v1/sessions", json={})
        assert (refused.status_code, kind(refused)) == (401, "unauthenticated")
        assert "makes the first by `voa keys create NAME --role operator`" in refused.json()["detail"]
        assert http.get("/v1/lidars", headers=bearer(key_for(service, "viewer"))).status_code == 200


def test_too_many_calls_without_a_valid_key_from_an_address_are_429_and_not_in_the_audit(
    tmp_path: Path,
) -> None:
    with serving(tmp_path, rates=RateSettings(refused="3/hour")) as service, audited() as audit:
        own, guessed = (
            bearer(key_for(service, "viewer")),
            [{}, bearer("nonsense"), bearer(f"voa_{'0' * 12}_{'0' * 64}")],
        )
        refused = [service.http.post("/v1/objects", headers=each) for each in (*guessed, *guessed)]
        assert [answer.status_code for answer in refused] == [401, 401, 401, 429, 429, 429]
        assert kind(refused[-1]) == "too-many-without-key"
        assert int(refused[-1].headers["Retry-After"]) > 3_000
        assert service.http.get("/v1/lidars", headers=own).status_code == 200, "a valid key is accepted everywhere"
        assert service.http.get("/readyz").status_code == 200
    assert audit.of("object.create") == [("unknown", 401)] * 3


def test_running_services_of_a_database_notice_keys_within_seconds(tmp_path: Path) -> None:
    with serving(tmp_path) as one, serving(tmp_path) as two:
        url = url_of(one.database)
        made = make_key(url, "viewer", expires_at=datetime.now(UTC) + timedelta(days=1))
        began = time.monotonic()
        for service in (one, two):
            wait_for(partial(_is_refused, service, {}), "the first key")
            assert service.http.get("/v1/lidars", headers=bearer(made)).status_code == 200
        assert time.monotonic() - began < 5 * REFRESH_SECONDS
        revoke_key(url, made)
        for service in (one, two):
            wait_for(partial(_is_refused, service, bearer(made)), "the revocation")
        assert one.http.get("/v1/lidars").status_code == 401, "the last key's revocation opens nothing"
        wait_for(lambda: _last_use(one), "the last use")
    with serving(tmp_path) as again:
        assert again.http.get("/v1/lidars").status_code == 401


def _is_refused(service: Service, headers: Json) -> bool:
    return service.http.get("/v1/lidars", headers=headers).status_code == 401


def _last_use(service: Service) -> bool:
    return service.inside.sessions.store.list_keys()[0].last_used_at is not None
