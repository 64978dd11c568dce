"""The table of roles: every route and every method has its roles, and none is left over."""

import re
from collections.abc import Iterator
from typing import cast

import pytest
from fastapi import FastAPI
from starlette.routing import Mount, Route

from tests.support.serving import Service
from voa_service.access.roles import BY_NAME, CALLS, EVERYBODY, OPERATORS, ROLES, UNLISTED
from voa_service.access.routing import Routes
from voa_service.rpc.methods import methods_of

ONLY_HTTP = {"service.alive", "service.metrics", "service.describe", "service.open", "session.follow", "robot.claim"}
ONLY_PUT = {"scan.put"}


def bare(path: str) -> str:
    return re.sub(r"\{\w+\}", "{}", path)


def routes_of(service: Service) -> Iterator[tuple[str, str]]:
    """Every route of the application, method and path."""
    app = cast(FastAPI, service.http.app)
    for path, methods in app.openapi()["paths"].items():
        yield from ((method.upper(), bare(path)) for method in methods)
    for route in app.routes:
        if isinstance(route, Mount):
            yield "GET", f"{route.path}/{{}}"
        elif isinstance(route, Route):
            yield from ((method, bare(route.path)) for method in (route.methods or set()) - {"HEAD"})


def test_every_route_has_roles_and_no_row_is_left_over(service: Service) -> None:
    table = {tuple(bare(route).split(" ")) for call in CALLS for route in call.routes}
    assert set(routes_of(service)) == table


def test_every_route_is_matched_with_its_own_row(service: Service) -> None:
    routes = Routes(CALLS)
    for method, path in routes_of(service):
        assert routes.match(method, path.replace("{}", "abc")).call is not UNLISTED, (method, path)


def test_every_method_has_roles_and_no_row_is_left_over(service: Service) -> None:
    assert set(methods_of(service.inside)) | ONLY_HTTP | ONLY_PUT == set(BY_NAME)
    assert not set(methods_of(service.inside)) & (ONLY_HTTP | ONLY_PUT)


def test_health_alone_is_public() -> None:
    assert {call.name for call in CALLS if call.public} == {"service.alive", "service.health"}


def test_every_call_may_be_made_by_an_operator_and_every_read_by_everybody() -> None:
    for call in CALLS:
        assert call.roles >= OPERATORS
        assert call.roles <= set(ROLES)
        assert call.writes or call.roles == EVERYBODY, call.name


@pytest.mark.parametrize(
    ("role", "writes"),
    [
        ("viewer", set()),
        ("arm", {"outcome.report"}),
        ("sensor", {"scan.apply", "scan.put", "look.announce", "look.cancel", "robot.look"}),
        ("operator", {call.name for call in CALLS if call.writes}),
    ],
)
def test_the_writes_of_each_role(role: str, writes: set[str]) -> None:
    assert {call.name for call in CALLS if call.writes and role in call.roles} == writes


def test_methods_of_http_that_change_something_are_writes_unless_they_only_compute() -> None:
    computing = {"scenario.predict", "voa.rank", "update.compute", "ranking.compute"}
    changing = {call.name for call in CALLS if any(not route.startswith("GET ") for route in call.routes)}
    assert changing == {call.name for call in CALLS if call.writes} - ONLY_PUT | computing
