"""The entry of remote calls: it answers in messages and problem documents, counts and logs, and hides defects."""

import json
from typing import Any

import pytest
import structlog

from tests.support.serving import Service, json_of
from voa_service.rpc.entry import Rpc, RpcAnswer


@pytest.fixture
def rpc(service: Service) -> Rpc:
    return Rpc(service.inside)


def problem(answer: RpcAnswer) -> dict[str, Any]:
    assert answer.is_problem
    assert answer.version is None
    return dict(json.loads(answer.body))


def test_a_message_is_answered_with_every_field(rpc: Rpc, service: Service, data_id: str) -> None:
    answer = rpc.answer("scenario.get", json_of({"id": data_id}))
    assert (answer.is_problem, answer.version) == (False, None)
    assert json.loads(answer.body) == service.get(f"/v1/scenarios/{data_id}")


def test_a_stored_response_is_answered_with_the_version_of_its_session(rpc: Rpc, data_id: str) -> None:
    answer = rpc.answer("session.create", json_of({"scenario": data_id}))
    assert (answer.is_problem, answer.version) == (False, 0)
    session = json.loads(answer.body)["id"]
    answer = rpc.answer("belief.put", json_of({"session": session, "belief": None}))
    assert answer.version == json.loads(answer.body)["version"] == 1


def test_an_empty_payload_has_no_fields(rpc: Rpc, service: Service) -> None:
    assert json.loads(rpc.answer("lidar.list", b"").body) == service.get("/v1/lidars")


def test_an_unknown_method_is_refused_with_the_known_ones_and_waits_with_the_reads(rpc: Rpc, service: Service) -> None:
    document = problem(rpc.answer("scan.guess", b"{}"))
    assert (document["status"], document["type"]) == (404, "urn:voa:problem:not-found")
    assert "scan.apply" in document["known"]
    assert rpc.queue("scan.guess") is service.inside.reads
    assert rpc.queue("scan.apply") is service.inside.writes


def test_a_caller_of_another_wire_version_is_refused(rpc: Rpc) -> None:
    assert not rpc.answer("lidar.list", b"", b'{"wire": 1}').is_problem
    assert problem(rpc.answer("lidar.list", b"", b'{"wire": 99}'))["type"] == "urn:voa:problem:wire-version"


def test_an_error_of_the_mathematics_becomes_a_problem(rpc: Rpc, data_id: str) -> None:
    document = problem(rpc.answer("ranking.compute", json_of({"scenario": data_id, "belief": [0.5, 0.5]})))
    assert (document["status"], document["type"]) == (422, "urn:voa:problem:invalid-request")


def test_a_defect_becomes_a_problem_without_its_secrets(
    rpc: Rpc, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken() -> object:
        raise ZeroDivisionError("a secret")

    monkeypatch.setattr(service.inside.robots, "reports", broken)
    answer = rpc.answer("robot.list", b"")
    assert problem(answer)["type"] == "urn:voa:problem:internal"
    assert b"secret" not in answer.body


def test_calls_are_counted_by_method_and_status_and_logged_under_the_id_of_their_problem(
    rpc: Rpc, service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    with structlog.testing.capture_logs([structlog.contextvars.merge_contextvars]) as logs:
        document = problem(rpc.answer("session.get", json_of({"id": "nothing"})))
        rpc.answer("no.such", b"")
    calls = [(event["method"], event["status"]) for event in logs if event["event"] == "rpc"]
    assert calls == [("session.get", 404), ("no.such", 404)]
    assert document["request_id"] == logs[0]["request_id"] != logs[1]["request_id"]
    text = service.inside.metrics.text().decode()
    assert 'voa_rpc_requests_total{method="session.get",status="404"} 1.0' in text
    assert 'voa_rpc_requests_total{method="none",status="404"}' in text
    assert "no.such" not in text


@pytest.mark.parametrize(
    ("method", "attachment", "may"),
    [
        ("session.get", None, True),
        ("voa.rank", b'{"id": "k"}', True),
        ("scan.apply", b'{"id": "k"}', True),
        ("scan.apply", b'{"sensor": "Q1"}', False),
        ("scan.apply", None, False),
        ("session.create", None, False),
        ("scan.apply", b"no JSON", True),  # is refused each time
        ("scan.guess", None, True),
    ],
)
def test_a_read_and_a_write_with_an_id_may_be_repeated(
    rpc: Rpc, method: str, attachment: bytes | None, may: bool
) -> None:
    assert rpc.may_repeat(method, attachment) is may
