"""Every kind of bad input gets its problem document, and leaves everything that is stored as it was."""

import re
from collections.abc import Iterator
from typing import Any

import pytest

from tests.contract.bad_input.base import (
    GOOD,
    INVALID,
    UPDATE,
    Case,
    World,
    check_problem,
    filled,
    send,
    stocked_service,
)
from tests.contract.bad_input.cases import CASES
from tests.support.serving import LIDAR, Service, data_scenario, scan_of


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with stocked_service(tmp_path_factory.mktemp("bad")) as own:
        yield own


def test_names_of_the_cases_differ() -> None:
    names = [case.name for case in CASES]
    assert sorted(set(names)) == sorted(names)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_bad_input_gets_its_problem_and_changes_nothing(world: World, case: Case) -> None:
    before = world.service.stored()
    answer = send(world, case)
    check_problem(answer, case.status, case.kind, case.says)
    assert world.service.stored() == before


@pytest.fixture(scope="module")
def documented(world: World) -> dict[tuple[str, str, int], set[str]]:
    """Kinds of problems that the OpenAPI document lists, by method, path and status."""
    document = world.service.get("/openapi.json")
    schemas = document["components"]["schemas"]

    def kinds(schema: dict[str, Any]) -> set[str]:
        references = [one["$ref"].rpartition("/")[2] for one in schema.get("oneOf", [schema])]
        return {schemas[name]["properties"]["type"]["const"] for name in references}

    return {
        (method.upper(), path, int(status)): kinds(response["content"]["application/problem+json"]["schema"])
        for path, operations in document["paths"].items()
        for method, operation in operations.items()
        for status, response in operation["responses"].items()
        if status >= "400"
    }


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_document_lists_the_problem_of_each_case(
    documented: dict[tuple[str, str, int], set[str]], case: Case
) -> None:
    kinds = {
        kind
        for (method, template, status), listed in documented.items()
        if (method, status) == (case.method, case.status)
        and re.fullmatch(re.sub(r"{\w+}", "[^/]+", template), case.path.partition("?")[0])
        for kind in listed
    }
    assert f"urn:voa:problem:{case.kind}" in kinds or case.path in ("/v1/nothing", "/v2/scenarios")


def test_a_key_that_came_with_another_request_is_refused(world: World) -> None:
    path = f"/v1/sessions/{world.service.open(world.data)}/scans"
    key = {"idempotency-key": "once"}
    assert world.service.http.post(path, json=scan_of(GOOD), headers=key).status_code == 200
    before = world.service.stored()
    answer = world.service.http.post(path, json=scan_of([0.6, 0.5, None, 1.0]), headers=key)
    check_problem(answer, 422, "idempotency-key-reused", "once")
    assert world.service.stored() == before


METHODS = {
    "/v1/objects": {"GET", "POST"},
    "/v1/objects/{object}": {"GET", "DELETE"},
    "/v1/objects/{object}/stable-poses": {"GET"},
    "/v1/objects/{object}/mesh": {"GET"},
    "/v1/objects/{object}/mesh.stl": {"GET"},
    "/v1/lidars": {"GET"},
    "/v1/caller": {"GET"},
    "/v1/scenarios": {"GET", "POST"},
    "/v1/scenarios/{data}": {"GET", "DELETE"},
    "/v1/scenarios/{data}/warnings": {"GET"},
    "/v1/scenarios/{data}/predictions": {"POST"},
    "/v1/sessions": {"GET", "POST"},
    "/v1/sessions/{data_session}": {"GET", "DELETE"},
    "/v1/sessions/{data_session}/scans": {"POST"},
    "/v1/sessions/{data_session}/belief": {"PUT"},
    "/v1/sessions/{data_session}/grasp-outcomes": {"POST"},
    "/v1/sessions/{data_session}/looks": {"POST"},
    "/v1/sessions/{data_session}/looks/nothing": {"DELETE"},
    "/v1/sessions/{data_session}/history": {"GET"},
    "/v1/sessions/{data_session}/events": {"GET"},
    "/v1/sessions/{data_session}/voa": {"GET", "POST"},
    "/v1/sessions/{data_session}/grasps": {"GET"},
    "/v1/updates": {"POST"},
    "/v1/rankings": {"POST"},
    "/v1/robots": {"GET"},
    "/v1/robots/nobody/look": {"POST"},
    "/v1/robots/nobody/scan": {"GET"},
    "/v1/robots/nobody/session": {"PUT"},
    "/livez": {"GET"},
    "/readyz": {"GET"},
    "/metrics": {"GET"},
}


@pytest.mark.parametrize(
    ("path", "method"),
    [
        (path, method)
        for path, has in METHODS.items()
        for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
        if method not in has
    ],
)
def test_a_method_that_a_path_does_not_have_is_405_and_all_that_it_has_are_named(
    world: World, path: str, method: str
) -> None:
    answer = world.service.http.request(method, filled(path, world))
    check_problem(answer, 405, "method-not-allowed", method)
    assert set(answer.headers["allow"].split(", ")) == METHODS[path]


def test_every_resource_is_in_the_table_of_methods(world: World) -> None:
    document = world.service.get("/openapi.json")
    assert len(document["paths"]) == len(METHODS)
    assert sum(map(len, document["paths"].values())) == sum(map(len, METHODS.values()))


@pytest.mark.parametrize("rule", ["margin", "exponential", "gaussian", "inverse_rmsd", "beam"])
@pytest.mark.parametrize("reading", [0.0, 1e-320, 1e308, 1.7e308])
def test_whatever_a_driver_sends_as_a_range_becomes_a_belief(world: World, rule: str, reading: float) -> None:
    lidar = LIDAR | {"range_max": 1e6, "range_min": 0.0}
    scenario = world.service.create(data_scenario(lidar=lidar, update={"rule": rule, "on_no_match": "nearest"}))
    answer = world.service.post("/v1/updates", UPDATE | {"scenario": scenario, "scan": {"ranges": [reading] * 4}})
    assert all(isinstance(share, float) for share in answer["belief"])
    assert sum(answer["belief"]) == pytest.approx(1.0, abs=1e-9)


def test_a_million_beams_are_refused_by_the_limits_of_a_default_service_too(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    before = service.stored()
    answer = service.http.post(f"/v1/sessions/{session}/scans", json=scan_of([1.0] * 1_000_000))
    check_problem(answer, 422, INVALID, "at most 4096")
    assert service.stored() == before
