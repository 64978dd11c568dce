"""Direct calls of operations: they answer as FastAPI does, and the operations that robots call often are direct."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.routing import APIRoute
from httpx2 import Response
from starlette.exceptions import HTTPException
from starlette.testclient import TestClient

from tests.support.serving import Service, data_scenario, scan_of, serving
from voa_connections.asgi import Message, Scope
from voa_service.http.app import create_app
from voa_service.http.direct import Direct

JSON = {"content-type": "application/json"}
BELIEF = b'{"belief": [0.2, 0.3, 0.5]}'
VARYING = ("x-request-id", "etag", "content-length")


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with serving(tmp_path_factory.mktemp("direct")) as service:
        yield service


@pytest.fixture(scope="module")
def of_fastapi(service: Service) -> Iterator[TestClient]:
    """A client of the same services, whose requests FastAPI alone serves."""
    app = create_app(service.inside)
    app.router.middleware_stack = app.router.app
    with TestClient(app, "http://127.0.0.1", raise_server_exceptions=False) as http:
        yield http


@pytest.fixture(scope="module")
def session(service: Service) -> str:
    return service.open(service.create(data_scenario()))


def direct_of(service: Service) -> Direct:
    app: Any = create_app(service.inside)
    direct: Direct = app.router.middleware_stack
    return direct


def scope_of(method: str, path: str, query: bytes = b"", **more: Any) -> Scope:
    return more | {"type": "http", "method": method, "path": path, "query_string": query}


def seen(response: Response) -> tuple[int, Any, dict[str, str]]:
    """Status, body and headers of a response, without those that differ between two requests."""
    body = response.json() if response.content else None
    if isinstance(body, dict):
        body = {name: value for name, value in body.items() if name not in ("request_id", "updated_at", "version")}
    headers = {name: value for name, value in response.headers.items() if name not in VARYING}
    return response.status_code, body, headers


@pytest.mark.parametrize(
    ("method", "path", "body", "headers"),
    [
        ("GET", "/v1/sessions/{id}", b"", {}),
        ("GET", "/v1/sessions/{id}", BELIEF, {"content-type": "text/plain"}),
        ("GET", "/v1/sessions/unknown", b"", {}),
        ("GET", "/v1/sessions/{id}/", b"", {}),
        ("GET", "/v1/sessions//scans", b"", {}),
        ("GET", "/v1/sessions/%20a%2Fb", b"", {}),
        ("GET", "/v1/sessions/{id}?limit=1", b"", {}),
        ("HEAD", "/v1/sessions/{id}", b"", {}),
        ("PATCH", "/v1/sessions/{id}", b"", {}),
        ("GET", "/v1/sessions", b"", {}),
        ("GET", "/v1/sessions?limit=0", b"", {}),
        ("PUT", "/v1/sessions/{id}/belief", b"", JSON),
        ("PUT", "/v1/sessions/{id}/belief", b"{", JSON),
        ("PUT", "/v1/sessions/{id}/belief", b"null", JSON),
        ("PUT", "/v1/sessions/{id}/belief", b'{"belief": [1], "belief": null}', JSON),
        ("PUT", "/v1/sessions/{id}/belief", b'{"beliefs": null}', JSON),
        ("PUT", "/v1/sessions/{id}/belief", b"\xff", JSON),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, {"content-type": "text/plain"}),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, {"content-type": "application/json; charset=utf-8"}),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, {}),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, JSON | {"idempotency-key": ""}),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, JSON | {"idempotency-key": "k" * 256}),
        ("PUT", "/v1/sessions/{id}/belief", BELIEF, JSON | {"if-match": '"v99999"'}),
        ("PUT", "/v1/sessions/{id}/belief", b"{", JSON | {"idempotency-key": ""}),
        ("PUT", "/v1/sessions/unknown/belief", BELIEF, JSON),
        ("POST", "/v1/sessions/{id}/scans", b'{"sensor": "Q1", "scan": {"ranges": [1]}}', JSON),
        ("POST", "/v1/sessions/{id}/voa", b"", {}),
        ("POST", "/v1/sessions/{id}/voa", b" null ", JSON),
        ("POST", "/v1/sessions/{id}/voa", b'{"definition": "executed"}', JSON),
        ("POST", "/v1/sessions/{id}/voa", b"3", JSON),
        ("POST", "/v1/scenarios", b'{"name": 3}', JSON),
    ],
)
def test_a_request_is_answered_as_by_fastapi(
    service: Service,
    of_fastapi: TestClient,
    session: str,
    method: str,
    path: str,
    body: bytes,
    headers: dict[str, str],
) -> None:
    ours, theirs = (
        http.request(method, path.replace("{id}", session), content=body, headers=headers)
        for http in (service.http, of_fastapi)
    )
    assert seen(ours) == seen(theirs)


def test_a_scan_is_answered_as_by_fastapi(service: Service, of_fastapi: TestClient, session: str) -> None:
    scan, key = scan_of([0.5, 0.5, None, 1.0]), {"idempotency-key": "same"}
    ours, theirs = (
        http.post(f"/v1/sessions/{session}/scans", json=scan, headers=key) for http in (service.http, of_fastapi)
    )
    assert ours.status_code == 200
    assert (ours.content, ours.headers["etag"]) == (theirs.content, theirs.headers["etag"])


@pytest.mark.parametrize(
    ("method", "path", "name"),
    [
        ("POST", "/v1/sessions/a/scans", "apply_scan"),
        ("POST", "/v1/sessions/a/grasp-outcomes", "report_outcome"),
        ("PUT", "/v1/sessions/a/belief", "put_belief"),
        ("GET", "/v1/sessions/a", "get_session"),
        ("POST", "/v1/sessions/a/voa", "rank_given_looks"),
    ],
)
def test_the_operations_that_robots_call_often_are_direct(service: Service, method: str, path: str, name: str) -> None:
    matched = direct_of(service).find(scope_of(method, path))
    assert matched is not None
    operation, values = matched
    assert operation.route.name == name
    assert values == {"id": "a"}


def test_the_walk_of_a_path_finds_the_route_that_fastapi_finds(service: Service) -> None:
    app = create_app(service.inside)
    direct: Any = app.router.middleware_stack
    for path, methods in app.openapi()["paths"].items():
        for method in methods:
            scope = scope_of(method.upper(), path.replace("{", "").replace("}", ""))
            matched = direct.find(scope)
            if matched is not None:
                route = matched[0].route
                assert isinstance(route, APIRoute)
                assert route.path == path
                assert method.upper() in (route.methods or ())
                assert app.openapi()["paths"][path][method]["operationId"] == route.name


@pytest.mark.parametrize(
    "scope",
    [
        scope_of("GET", "/v1/sessions/a", b"limit=3"),
        scope_of("GET", "/v1/sessions/a", root_path="/lab"),
        scope_of("GET", "/v1/sessions/"),
        scope_of("GET", "/v1/nothing/a"),
        scope_of("POST", "/v1/objects"),
        {"type": "lifespan"},
    ],
)
def test_other_requests_are_left_to_fastapi(service: Service, scope: Scope) -> None:
    assert direct_of(service).find(scope) is None


def test_a_client_that_leaves_before_its_body_ends_is_no_defect(service: Service) -> None:
    arriving: list[Message] = [
        {"type": "http.request", "body": b"{", "more_body": True},
        {"type": "http.disconnect"},
    ]

    async def receive() -> Message:
        return arriving.pop(0)

    async def drop(_: Message) -> None:
        """Send nothing."""

    headers = [(b"content-type", b"application/json"), (b"content-length", b"9")]
    with pytest.raises(HTTPException) as refused:
        asyncio.run(direct_of(service)(scope_of("PUT", "/v1/sessions/a/belief", headers=headers), receive, drop))
    assert refused.value.status_code == 400
