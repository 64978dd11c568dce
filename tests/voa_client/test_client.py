"""The client against the real service, and against servers that are no VOA service."""

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any, ClassVar

import pytest

from tests.support.serving import data_scenario
from voa_client import Client, ProblemError, Retries, UnavailableError, UnreachableError
from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import Scan, ScanRequest, SessionRequest, UpdateRequest

ONCE = Retries(within_s=0.0)


def test_every_call_goes_through_messages(process: str) -> None:
    with Client(process) as client:
        assert client.ready().status == "ready"
        assert "lds-01" in [preset.name for preset in client.lidars().items]
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        assert client.get_scenario(scenario.id) == scenario
        predicted = client.predict(scenario.id, PredictionsRequest(sensors=["Q1"]))
        assert (predicted.sensors, predicted.poses) == (["Q1"], ["P1", "P2", "P3"])
        session = client.create_session(SessionRequest(scenario=scenario.id))
        scan = Scan(ranges=[0.5, 0.5, None, 1.0], no_return=[2])
        once = client.update_once(UpdateRequest(scenario=scenario.id, belief=session.belief, sensor="Q1", scan=scan))
        after = client.apply_scan(session.id, ScanRequest(sensor="Q1", scan=scan))
        assert once.belief == after.belief
        assert client.get_session(session.id).version == after.version == 1
        assert client.rank_looks(session.id).version == 1
        assert client.rank_once(RankingRequest(scenario=scenario.id, belief=after.belief)).version is None
        assert [grasp.name for grasp in client.rank_grasps(session.id, ["G2"]).grasps] == ["G2"]


def test_a_refusal_carries_the_problem(process: str) -> None:
    with Client(process) as client, pytest.raises(ProblemError, match="'nothing'") as refused:
        client.get_session("nothing")
    assert refused.value.kind == "not-found"
    assert refused.value.problem.status == 404
    assert refused.value.problem.request_id


def test_nobody_there_is_unreachable() -> None:
    here = Client("http://127.0.0.1:1", retries=ONCE)
    with here as client, pytest.raises(UnreachableError, match=r"127\.0\.0\.1:1"):
        client.ready()


class Strange(BaseHTTPRequestHandler):
    """A proxy in between, or a newer service."""

    answers: ClassVar[dict[str, tuple[int, str, Any]]] = {
        "/readyz": (200, "application/json", {"status": "ready", "mood": "fine"}),
        "/v1/lidars": (502, "text/html", "<h1>Bad gateway</h1>"),
        "/v1/sessions/new": (404, "application/problem+json", {
            "type": "urn:voa:problem:not-found", "title": "No", "status": 404, "detail": "none", "hint": "newer"}),
    }  # fmt: skip

    def do_GET(self) -> None:
        status, kind, body = self.answers[self.path]
        content = (body if isinstance(body, str) else json.dumps(body)).encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the base class's name
        return


@pytest.fixture
def strange() -> Iterator[str]:
    with HTTPServer(("127.0.0.1", 0), Strange) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


def test_what_a_newer_service_says_besides_is_ignored(strange: str) -> None:
    with Client(strange) as client:
        assert client.ready().status == "ready"
        with pytest.raises(ProblemError, match="none") as refused:
            client.get_session("new")
    assert refused.value.kind == "not-found"


def test_an_error_of_something_in_between_is_a_problem_too(strange: str) -> None:
    with Client(strange, retries=ONCE) as client, pytest.raises(UnavailableError, match="Bad gateway") as refused:
        client.lidars()
    assert (refused.value.kind, refused.value.problem.status) == ("http-error", 502)
