"""Bad input by method name instead of HTTP: the same problems for the cases of bad input, and no change."""

import json
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest

from tests.contract.bad_input.base import LIMITS, Case, World, filled, stocked_service
from tests.contract.bad_input.cases import CASES
from tests.support.serving import json_of, scan_of
from voa_service.rpc.entry import Rpc

METHODS = (
    (r"/v1/scenarios", "POST", "scenario.create"),
    (r"/v1/scenarios/(?P<id>[^/]+)/predictions", "POST", "scenario.predict"),
    (r"/v1/sessions", "POST", "session.create"),
    (r"/v1/sessions/(?P<session>[^/]+)/scans", "POST", "scan.apply"),
    (r"/v1/sessions/(?P<session>[^/]+)/belief", "PUT", "belief.put"),
    (r"/v1/sessions/(?P<session>[^/]+)/grasp-outcomes", "POST", "outcome.report"),
    (r"/v1/sessions/(?P<session>[^/]+)/voa", "POST", "voa.rank"),
    (r"/v1/sessions/(?P<session>[^/]+)/looks", "POST", "look.announce"),
    (r"/v1/updates", "POST", "update.compute"),
    (r"/v1/rankings", "POST", "ranking.compute"),
)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with stocked_service(tmp_path_factory.mktemp("rpc")) as own:
        yield own


class Called(NamedTuple):
    method: str
    payload: bytes
    attachment: bytes | None


def as_call(case: Case, world: World) -> Called | None:
    """The call that a request over HTTP is; None: it is about something that HTTP alone has."""
    if not isinstance(case.body, dict) or set(case.headers) - {"idempotency-key"}:
        return None
    path = filled(case.path, world)
    for pattern, verb, method in METHODS:
        match = re.fullmatch(pattern, path)
        if match and case.method == verb:
            body: dict[str, Any] = json.loads(filled(json_of(case.body).decode(), world))
            key = case.headers.get("idempotency-key")
            attachment = None if key is None else json_of({"id": key})
            return Called(method, json_of(body | match.groupdict()), attachment)
    return None


def names_of_calls() -> list[Case]:
    anywhere = World(*["x"] * 6)  # type: ignore[arg-type] # only which method it is matters here
    return [case for case in CASES if as_call(case, anywhere) is not None]


def test_most_cases_are_calls_too() -> None:
    assert len(names_of_calls()) > 250


@pytest.mark.parametrize("case", names_of_calls(), ids=lambda case: case.name)
def test_a_bad_call_gets_its_problem_and_changes_nothing(world: World, case: Case) -> None:
    called = as_call(case, world)
    assert called is not None
    before = world.service.stored()
    answer = Rpc(world.service.inside).answer(*called)
    assert answer.is_problem
    problem = json.loads(answer.body)
    assert problem["type"] == f"urn:voa:problem:{case.kind}", problem
    assert problem["status"] == case.status
    assert case.says.replace("Idempotency-Key", "attachment.id") in problem["detail"]
    assert world.service.stored() == before


SCAN = {"scan": {"ranges": [0.5, 0.5, None, 1.0]}}


@pytest.mark.parametrize(
    ("method", "payload", "attachment", "kind", "says"),
    [
        ("scan.guess", b"{}", None, "not-found", "'scan.guess'"),
        ("scan.apply", b"[1]", None, "invalid-request", "object"),
        ("scan.apply", b"", None, "invalid-request", "body.session"),
        ("scan.apply", b"{", None, "malformed-json", "character"),
        ("scan.apply", b"\xff\xfe", None, "malformed-json", "UTF-8"),
        ("scan.apply", b'{"session": "\0"}', None, "malformed-json", "NUL"),
        ("scan.apply", b"[" * 100_000, None, "malformed-json", "nested"),
        ("scan.apply", b" " * (LIMITS.body_bytes + 1), None, "too-large", "bytes"),
        ("scan.apply", b"," * (LIMITS.numbers + 1), None, "too-large", "values"),
        ("scan.apply", b"{}", b"not json", "invalid-request", "attachment"),
        ("scan.apply", b"{}", b'{"colour": 1}', "invalid-request", "attachment.colour"),
        ("scan.apply", b"{}", b'{"id": ""}', "invalid-request", "attachment.id"),
        ("scan.apply", b"{}", b"[]", "invalid-request", "attachment"),
        ("scan.apply", b"{}", b" " * 70_000, "invalid-request", "65536 bytes"),
        ("scan.apply", b"{}", b'{"wire": 99}', "wire-version", "99"),
        ("session.get", b'{"session": 7}', None, "invalid-request", "body.session"),
        ("session.get", b'{"session": "x", "colour": 1}', None, "invalid-request", "colour"),
        ("session.get", b'{"session": "nothing"}', None, "not-found", "'nothing'"),
        ("session.get", b'{"id": "nothing"}', None, "not-found", "'nothing'"),
        ("session.list", b'{"limit": 0}', None, "invalid-request", "limit"),
        ("session.list", b'{"after": "abc"}', None, "invalid-request", "`next` of a page"),
        ("object.create", b'{"filename": "a.obj", "file": "***"}', None, "invalid-request", "file"),
        ("object.create", b'{"filename": "a.exe", "file": ""}', None, "unsupported-mesh-type", "exe"),
        ("object.get", b"{}", None, "invalid-request", "body.id"),
        ("look.cancel", b'{"session": "x"}', None, "invalid-request", "body.look"),
        ("look.cancel", b'{"session": "nothing", "look": "L"}', None, "not-found", "'nothing'"),
        ("robot.look", b'{"robot": "nobody"}', None, "not-found", "'nobody'"),
        ("robot.scan", b'{"robot": "nobody"}', None, "not-found", "'nobody'"),
    ],
)
def test_bad_payloads_and_attachments(
    world: World, method: str, payload: bytes, attachment: bytes | None, kind: str, says: str
) -> None:
    before = world.service.stored()
    answer = Rpc(world.service.inside).answer(method, payload, attachment)
    problem = json.loads(answer.body)
    assert answer.is_problem
    assert problem["type"] == f"urn:voa:problem:{kind}", problem
    assert says in problem["detail"]
    assert world.service.stored() == before


def test_where_a_scan_was_taken_is_said_once(world: World) -> None:
    rpc = Rpc(world.service.inside)
    session = world.service.open(world.data)
    body = {"session": session} | SCAN
    both = rpc.answer("scan.apply", json_of(body | {"sensor": "Q1"}), b'{"sensor": "Q2"}')
    assert both.is_problem
    assert "both say" in json.loads(both.body)["detail"]
    assert rpc.answer("scan.apply", json_of(body), b'{"sensor": "Q1"}').version == 1
    history = world.service.get(f"/v1/sessions/{session}/history")["items"]
    assert history[1]["request"] == SCAN | {"sensor": "Q1"}


def test_a_key_means_the_same_call_by_name_and_over_http(world: World) -> None:
    session = world.service.open(world.data)
    body = scan_of([0.5, 0.5, None, 1.0])
    first = world.service.post(f"/v1/sessions/{session}/scans", body, **{"Idempotency-Key": "one"})
    again = Rpc(world.service.inside).answer("scan.apply", json_of(body | {"session": session}), b'{"id": "one"}')
    assert json.loads(again.body) == first
    assert world.service.get(f"/v1/sessions/{session}")["version"] == 1
