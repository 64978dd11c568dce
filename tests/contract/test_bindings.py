"""Keys that are bound to sessions or robots: every call about a session, by HTTP and by method, and every list."""

import json
from collections.abc import Iterator
from typing import Any, ClassVar

import pytest

from tests.support.api_keys import bearer, key_for, make_key, url_of
from tests.support.serving import Json, Service, data_scenario, json_of, scan_of, serving
from tests.voa_ros.ros_messages import scan as ros_scan
from voa_msgs.callers import Role
from voa_msgs.looks import LookAnnouncement
from voa_msgs.warnings import ProbableMistake
from voa_ros.pipeline import SeenScan
from voa_service.access.roles import BY_NAME, CALLS, Call
from voa_service.requests.idempotency import write_of
from voa_service.rpc.entry import Rpc
from voa_service.rpc.methods import methods_of
from voa_service.usecases.robot_reports import Standing

SCAN = scan_of([0.5, 0.5, None, 1.0])
BODIES: dict[str, Json] = {
    "scan.apply": SCAN,
    "belief.put": {"belief": None},
    "outcome.report": {"grasp": "G1", "success": True},
    "look.announce": {"sensor": "Q1"},
    "look.cancel": {"look": "x"},
    "session.delete": {},
    "voa.rank": {},
}
"""Bodies of the calls that need one, by their names."""
ABOUT_SESSIONS = [call for call in CALLS if call.on == "session" and call.routes]
WRITES = [call for call in ABOUT_SESSIONS if call.writes]
FOLLOW = BY_NAME["session.follow"]  # a stream without an end
REFUSED = 403


class Robot:
    """Robot that stands still, as the reports of robots see it."""

    waiting_for = None
    warnings: ClassVar[list[ProbableMistake]] = []
    standing = Standing()

    def request(self) -> None:
        """Take a look, which nobody receives."""


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with keys, and two mapped robots."""
    with serving(tmp_path_factory.mktemp("bound")) as service:
        scenario = service.create(data_scenario())
        for robot in ("r1", "r2"):
            service.inside.robots.mapped(robot, f"{robot}/scan", Robot(), scenario=scenario)
        key_for(service, "operator")
        yield service


@pytest.fixture(scope="module")
def operator(closed: Service) -> Json:
    return bearer(key_for(closed, "operator"))


@pytest.fixture
def session(closed: Service, operator: Json) -> str:
    return opened(closed, operator)


def opened(service: Service, headers: Json, *robots: str) -> str:
    """Open a session that claims robots, and return its id."""
    scenario = service.http.get("/v1/scenarios", headers=headers).json()["items"][0]["id"]
    answer = service.http.post("/v1/sessions", json={"scenario": scenario, "robots": list(robots)}, headers=headers)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def statuses(service: Service, call: Call, session: str, key: str) -> Iterator[int]:
    """Statuses of a call about a session, over each route that it has and as a method."""
    body = BODIES.get(call.name, {})
    for route in call.routes:
        method, _, path = route.partition(" ")
        path = path.replace("{session}", session).replace("{look}", str(body.get("look")))
        has_body = method in ("POST", "PUT")
        yield service.http.request(method, path, json=body if has_body else None, headers=bearer(key)).status_code
    if call.name in methods_of(service.inside):
        yield called(service, call.name, {"session": session} | body, key)[0]


def called(service: Service, method: str, body: Json, key: str) -> tuple[int, Json]:
    """Status and body of the response to a method."""
    answer = Rpc(service.inside).answer(method, json_of(body), json_of({"key": key}))
    response = json.loads(answer.body)
    return (int(response["status"]) if answer.is_problem else 200), response


@pytest.mark.parametrize("call", [each for each in ABOUT_SESSIONS if each is not FOLLOW], ids=lambda call: call.name)
def test_a_key_for_another_session_is_refused_by_every_call(closed: Service, session: str, call: Call) -> None:
    other = key_for(closed, "operator", sessions=("another",))
    assert set(statuses(closed, call, session, other)) == {REFUSED}
    own = key_for(closed, "operator", sessions=(session,))
    assert REFUSED not in set(statuses(closed, call, session, own))


@pytest.mark.parametrize("call", WRITES, ids=lambda call: call.name)
def test_a_key_for_a_robot_changes_the_session_that_claimed_it_and_no_other(
    closed: Service, operator: Json, session: str, call: Call
) -> None:
    assert call.name in BODIES, "a write to a session is tested by its body here"
    own = key_for(closed, "operator", robots=("r1",))
    assert set(statuses(closed, call, session, own)) == {REFUSED}
    claiming = opened(closed, operator, "r1")
    assert REFUSED not in set(statuses(closed, call, claiming, own))
    assert set(statuses(closed, call, session, own)) == {REFUSED}
    both = key_for(closed, "operator", sessions=(session,), robots=("r1",))
    assert REFUSED not in set(statuses(closed, call, session, both))


def test_a_robot_that_no_session_claimed_scans_where_it_announced_a_look(closed: Service, session: str) -> None:
    own, path = bearer(key_for(closed, "sensor", robots=("unmapped",))), f"/v1/sessions/{session}"
    look = {"sensor": "Q1", "robot": "unmapped"}

    def scanned(**headers: str) -> int:
        return closed.http.post(f"{path}/scans", json=SCAN, headers=own | headers).status_code

    assert scanned() == REFUSED
    assert closed.http.post(f"{path}/looks", json=look, headers=own).status_code == 201
    assert scanned(**{"Idempotency-Key": "k"}) == 200
    assert scanned(**{"Idempotency-Key": "k"}) == 200, "a repetition gets its first response, though the look is over"
    assert scanned(**{"Idempotency-Key": "other"}) == REFUSED


def test_a_method_takes_scans_of_a_robot_while_its_look_is_under_way(closed: Service, session: str) -> None:
    own = key_for(closed, "sensor", robots=("tb3_1",))

    def made(method: str, **fields: Any) -> tuple[int, Json]:
        return called(closed, method, {"session": session} | fields, own)

    assert made("scan.apply", **SCAN)[0] == REFUSED
    status, look = made("look.announce", sensor="Q2", robot="tb3_1")
    assert status == 200
    assert made("scan.apply", **SCAN)[0] == 200, "from another place"
    assert made("look.cancel", look=look["id"])[0] == 200
    assert made("scan.apply", **SCAN)[0] == REFUSED


def test_a_deletion_is_repeated_with_its_response(closed: Service, operator: Json) -> None:
    own = bearer(key_for(closed, "operator", robots=("r1",))) | {"Idempotency-Key": "k"}
    path = f"/v1/sessions/{opened(closed, operator, 'r1')}"
    assert [closed.http.delete(path, headers=own).status_code for _ in range(2)] == [204, 204]


def test_an_announcement_that_names_its_robot_stays_in_the_session_of_the_robot(
    closed: Service, operator: Json, session: str
) -> None:
    own = key_for(closed, "sensor", robots=("r2", "unmapped"))

    def announced(session: str, robot: str) -> set[int]:
        body = {"sensor": "Q1", "robot": robot}
        path = f"/v1/sessions/{session}/looks"
        made = closed.http.post(path, json=body, headers=bearer(own)).status_code
        return {made, called(closed, "look.announce", {"session": session} | body, own)[0]}

    assert announced(session, "unmapped") == {200, 201}
    assert announced(session, "another") == {REFUSED}
    claiming = opened(closed, operator, "r2")
    assert announced(claiming, "r2") == {200, 201}
    assert announced(session, "r2") == {REFUSED}


@pytest.mark.parametrize(
    ("role", "name", "may"),
    [("sensor", "anna", True), ("sensor", "ben", False), ("operator", "clara", True)],
)
def test_a_look_is_withdrawn_by_the_key_that_announced_it_or_an_operator(
    closed: Service, session: str, role: Role, name: str, may: bool
) -> None:
    url, path = url_of(closed.database), f"/v1/sessions/{session}/looks"
    announcing, withdrawing = make_key(url, "sensor", "anna"), make_key(url, role, name)
    closed.inside.gate.keyring.refresh()
    looks = [
        closed.http.post(path, json={"sensor": each}, headers=bearer(announcing)).json()["id"] for each in ("Q1", "Q2")
    ]
    assert closed.http.delete(f"{path}/{looks[0]}", headers=bearer(withdrawing)).status_code == (204 if may else 403)
    by_method = called(closed, "look.cancel", {"session": session, "look": looks[1]}, withdrawing)
    assert by_method[0] == (200 if may else 403)
    left = closed.http.get(f"/v1/sessions/{session}", headers=bearer(announcing)).json()["under_way"]
    assert [look["id"] for look in left] == ([] if may else looks)


def test_a_look_from_before_the_first_key_is_withdrawn_by_operators_alone(closed: Service, session: str) -> None:
    request = LookAnnouncement(sensor="Q1")
    look = json.loads(closed.inside.looks.announce(session, request, write_of("look", b"", None)).body)["id"]
    path = f"/v1/sessions/{session}/looks/{look}"
    assert closed.http.delete(path, headers=bearer(key_for(closed, "sensor"))).status_code == 403
    assert closed.http.delete(path, headers=bearer(key_for(closed, "operator"))).status_code == 204


@pytest.mark.parametrize("bound", ["sessions", "robots", "both", "neither"])
def test_lists_have_what_a_key_may_read_and_nothing_else(closed: Service, operator: Json, bound: str) -> None:
    claims = {opened(closed, operator, robot): robot for robot in ("r1", "r2")}
    session, other = claims
    for robot in ("r1", "r2"):
        closed.inside.robots.seen(robot, SeenScan(ros_scan(1.0), None), None)
    own = key_for(
        closed,
        "viewer",
        sessions=(session, "gone") if bound in ("sessions", "both") else None,
        robots=("r1",) if bound in ("robots", "both") else None,
    )
    for path, one, expected in (
        ("/v1/sessions", "{}", {session} if bound in ("sessions", "both") else {session, other}),
        ("/v1/robots", "{}/scan", {"r1", "r2"} if bound == "neither" else {"r1"}),
    ):
        everything = _names(closed.http.get(f"{path}?limit=1000" if "sess" in path else path, headers=operator).json())
        listed = _names(closed.http.get(f"{path}?limit=1000" if "sess" in path else path, headers=bearer(own)).json())
        method = "session.list" if "sess" in path else "robot.list"
        assert _names(called(closed, method, {}, own)[1]) == listed
        assert {each for each in listed if each in {*claims, "r1", "r2"}} == expected
        readable = [
            each
            for each in everything
            if closed.http.get(f"{path}/{one.format(each)}", headers=bearer(own)).status_code == 200
        ]
        assert listed == readable


def test_a_list_of_a_bound_key_has_pages(closed: Service, operator: Json) -> None:
    sessions = [opened(closed, operator) for _ in range(3)]
    own = bearer(key_for(closed, "viewer", sessions=(sessions[0], sessions[2])))
    first = closed.http.get("/v1/sessions?limit=1", headers=own).json()
    second = closed.http.get("/v1/sessions", params={"limit": 1, "after": first["next"]}, headers=own).json()
    assert [_names(first), _names(second), second["next"]] == [[sessions[0]], [sessions[2]], None]


def _names(listed: Json) -> list[str]:
    return [str(item.get("id") or item.get("robot")) for item in listed["items"]]
