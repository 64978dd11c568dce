"""Whose session a mapped robot's scans are for: said by PUT, by a new session, or settled at its first look."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.quiet_robot import QuietRobot
from tests.support.serving import Json, Service, data_scenario, serving
from voa_client import Client, ConflictError, HttpTransport, InvalidRequestError
from voa_msgs.robots import RobotReport
from voa_msgs.sessions import SessionRequest
from voa_service.requests.idempotency import idempotency_key, scope_of_caller

ROBOT = "tb3_1"


@pytest.fixture
def own(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path) as service:
        yield service


@pytest.fixture
def scenario(own: Service) -> str:
    """A scenario that two robots are mapped to."""
    id_ = own.create(data_scenario())
    for robot in (ROBOT, "tb3_2"):
        own.inside.robots.mapped(robot, f"{robot}/scan", QuietRobot(), scenario=id_)
    return id_


def put(service: Service, session: str | None, robot: str = ROBOT) -> Json:
    """The answer to a claim that must succeed."""
    answer = service.http.put(f"/v1/robots/{robot}/session", json={"session": session})
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def reported(service: Service) -> dict[str, str | None]:
    """The session of each robot, as /v1/robots has it."""
    return {report["robot"]: report["session"] for report in service.get("/v1/robots")["items"]}


def test_a_report_shows_the_session_that_a_look_would_go_to(own: Service, scenario: str) -> None:
    assert reported(own) == {ROBOT: None, "tb3_2": None}
    first = own.open(scenario)
    assert reported(own) == {ROBOT: first, "tb3_2": first}
    assert own.inside.claims.settle(ROBOT, scenario) == first
    second = own.open(scenario)
    assert reported(own) == {ROBOT: first, "tb3_2": second}


def test_a_claim_is_answered_with_the_report_and_shown_at_once(own: Service, scenario: str) -> None:
    first, second = own.open(scenario), own.open(scenario)
    answer = RobotReport.model_validate(put(own, first))
    assert (answer.robot, answer.session, answer.waiting_for) == (ROBOT, first, "a scan")
    assert reported(own) == {ROBOT: first, "tb3_2": second}
    assert own.inside.claims.peek(ROBOT, scenario) == own.inside.claims.settle(ROBOT, scenario) == first
    assert put(own, first)["session"] == first, "said again it is the same"
    assert put(own, second)["session"] == second
    assert reported(own)[ROBOT] == second


def test_a_robot_may_be_nobody_s(own: Service, scenario: str) -> None:
    own.open(scenario)
    assert put(own, None)["session"] is None
    newer = own.open(scenario)
    assert reported(own) == {ROBOT: None, "tb3_2": newer}
    assert own.inside.claims.settle(ROBOT, scenario) is None
    assert own.open(scenario, robots=[ROBOT]) == reported(own)[ROBOT]


def test_a_new_session_claims_its_robots_and_no_other_one_takes_them(own: Service, scenario: str) -> None:
    own.open(scenario)
    claimed = own.open(scenario, robots=["tb3_2", ROBOT])
    own.open(scenario)
    assert reported(own) == {ROBOT: claimed, "tb3_2": claimed}
    own.post("/v1/rankings", {"scenario": scenario, "belief": None})
    own.get(f"/v1/sessions/{claimed}/voa")
    assert reported(own) == {ROBOT: claimed, "tb3_2": claimed}
    [entry] = own.get(f"/v1/sessions/{claimed}/history")["items"]
    assert entry["request"] == {"scenario": scenario, "robots": ["tb3_2", ROBOT]}


@pytest.mark.parametrize("robots", [None, []])
def test_a_session_for_no_robots_claims_none(own: Service, scenario: str, robots: list[str] | None) -> None:
    first = own.open(scenario, robots=[ROBOT])
    own.open(scenario, robots=robots)
    assert reported(own)[ROBOT] == first


def test_a_session_that_cannot_have_one_robot_is_not_opened_and_gets_none(own: Service, scenario: str) -> None:
    first = own.open(scenario, robots=[ROBOT])
    answer = own.http.post("/v1/sessions", json={"scenario": scenario, "robots": [ROBOT, "nobody"]})
    assert answer.status_code == 422
    assert answer.json()["known"] == [ROBOT, "tb3_2"]
    assert [session["id"] for session in own.get("/v1/sessions")["items"]] == [first]
    assert reported(own)[ROBOT] == first


def test_a_creation_sent_again_claims_nothing_again_whatever_the_mapping_says_by_then(
    own: Service, scenario: str
) -> None:
    body, key = {"scenario": scenario, "robots": [ROBOT]}, {"Idempotency-Key": "K"}
    first = own.http.post("/v1/sessions", json=body, headers=key)
    second = own.open(scenario, robots=[ROBOT])
    assert own.http.post("/v1/sessions", json=body, headers=key).content == first.content
    assert reported(own)[ROBOT] == second
    own.inside.robots.unmapped(ROBOT)
    assert own.http.post("/v1/sessions", json=body, headers=key).content == first.content
    other = own.http.post("/v1/sessions", json={"scenario": scenario}, headers=key)
    assert other.json()["type"] == "urn:voa:problem:idempotency-key-reused"


@pytest.mark.parametrize(
    ("request_", "fingerprint"),
    [
        (SessionRequest(scenario="A"), "e8094d0c4d3ac5f6f980e053c6f60e4a5f065c47779a565e7a4552a3f61a0c27"),
        (
            SessionRequest(scenario="A", prior=[0.5, 0.5], robots=None),
            "af98f2b082c7a59dad450c1f0830a56cc46b56d8f1a749fa32640a2d5688389a",
        ),
    ],
)
def test_keys_from_before_there_were_claims_mean_the_same_request(request_: SessionRequest, fingerprint: str) -> None:
    key = idempotency_key("k", scope_of_caller("anonymous"), "create session", request_)
    assert key is not None
    assert key.fingerprint == fingerprint
    claiming = idempotency_key(
        "k", scope_of_caller("anonymous"), "create session", request_.model_copy(update={"robots": ["r"]})
    )
    assert claiming is not None
    assert claiming.fingerprint != fingerprint


def test_a_deleted_session_leaves_its_robot_to_the_next_one(own: Service, scenario: str) -> None:
    own.open(scenario)
    claimed = own.open(scenario, robots=[ROBOT])
    assert own.http.delete(f"/v1/sessions/{claimed}").status_code == 204
    assert reported(own)[ROBOT] is None, "an older session may be finished"
    after = own.open(scenario)
    assert reported(own)[ROBOT] == after


def test_a_claim_survives_the_process(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(data_scenario())
        service.inside.robots.mapped(ROBOT, "scan", QuietRobot(), scenario=scenario)
        first = service.open(scenario)
        put(service, first)
        service.open(scenario)
    with serving(tmp_path) as service:
        service.inside.robots.mapped(ROBOT, "scan", QuietRobot(), scenario=scenario)
        assert reported(service)[ROBOT] == first


def test_a_claim_at_one_replica_holds_at_the_other(tmp_path: Path) -> None:
    with serving(tmp_path) as one, serving(tmp_path) as other:
        scenario = one.create(data_scenario())
        for service in (one, other):
            service.inside.robots.mapped(ROBOT, "scan", QuietRobot(), scenario=scenario)
        first, second = one.open(scenario), other.open(scenario)
        assert [reported(service)[ROBOT] for service in (one, other)] == [second, second]
        put(one, first)
        assert [reported(service)[ROBOT] for service in (one, other)] == [first, first]
        assert [service.inside.claims.settle(ROBOT, scenario) for service in (one, other)] == [first, first]
        assert other.open(scenario, robots=[ROBOT]) == reported(one)[ROBOT]


def test_a_client_claims_and_gets_the_contradiction(own: Service, scenario: str) -> None:
    with Client(HttpTransport("http://127.0.0.1", own.http._transport)) as client:
        first, _ = own.open(scenario), own.open(scenario)
        assert client.claim_robot(ROBOT, first).session == first
        assert client.claim_robot(ROBOT, None).session is None
        opened = client.create_session(SessionRequest(scenario=scenario, robots=[ROBOT]))
        assert reported(own)[ROBOT] == opened.id
        other = own.open(own.create(data_scenario(name="another")))
        with pytest.raises(ConflictError, match="is mapped to scenario") as refused:
            client.claim_robot(ROBOT, other)
        assert refused.value.kind == "claim-conflict"
        with pytest.raises(InvalidRequestError, match="no session 'nothing'"):
            client.claim_robot(ROBOT, "nothing")
    assert reported(own)[ROBOT] == opened.id


def test_a_robot_whose_mapping_names_a_session_is_reported_there(own: Service, scenario: str) -> None:
    session = own.open(scenario)
    own.open(scenario)
    own.inside.robots.mapped("fixed", "scan", QuietRobot(), session=session)
    assert reported(own)["fixed"] == session


def test_a_process_without_a_mapping_says_so(own: Service) -> None:
    scenario = own.create(data_scenario())
    answer = own.http.post("/v1/sessions", json={"scenario": scenario, "robots": [ROBOT]})
    assert answer.status_code == 422
    assert "this process maps no robots, see `voa serve --robots FILE`" in answer.json()["detail"]
    answer = own.http.put(f"/v1/robots/{ROBOT}/session", json={"session": None})
    assert answer.status_code == 404
    assert "this process maps no robots" in answer.json()["detail"]


@pytest.mark.parametrize("prior", [None, [0.2, 0.3, 0.5]])
def test_a_belief_that_is_null_is_the_scenario_s_prior_and_opens_no_session(
    own: Service, prior: list[float] | None
) -> None:
    scenario = own.create(data_scenario(prior=prior))
    session = own.open(scenario)
    ranking = own.post("/v1/rankings", {"scenario": scenario, "belief": None, "outcomes": True})
    of_session = own.post(f"/v1/sessions/{session}/voa", {"outcomes": True})
    assert ranking == of_session | {"version": None}
    scan = {"sensor": "Q1", "scan": {"ranges": [0.52, 0.5, None, 1.0]}}
    update = own.post("/v1/updates", {"scenario": scenario, "belief": None} | scan)
    after = own.post(f"/v1/sessions/{session}/scans", scan)
    assert update["belief"] == after["belief"]
    assert update["update"] == after["update"]
    assert [each["id"] for each in own.get("/v1/sessions")["items"]] == [session]
