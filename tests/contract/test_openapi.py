"""The OpenAPI document says what the service does: limits, errors, operations."""

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.serving import Json, Service, serving
from voa_service.settings import Limits

LIMITS = Limits(beams=11, poses=12, sensors=13, grasps=14)


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> Json:
    with serving(tmp_path_factory.mktemp("limited"), limits=LIMITS) as service:
        answer: Json = service.get("/openapi.json")
    return answer


def operations(document: Json) -> Iterator[tuple[str, str, Json]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield path, method, operation


def nodes(node: Any) -> Iterator[Json]:
    """Every object in the document."""
    if isinstance(node, dict):
        yield node
        for child in node.values():
            yield from nodes(child)
    elif isinstance(node, list):
        for child in node:
            yield from nodes(child)


def test_it_is_openapi_3_1_with_a_title_and_a_version(document: Json) -> None:
    assert document["openapi"].startswith("3.1")
    assert document["info"]["title"]
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", document["info"]["version"])


def test_every_operation_has_an_id_of_its_own_a_summary_and_a_description(document: Json) -> None:
    ids = [operation["operationId"] for _, _, operation in operations(document)]
    assert sorted(set(ids)) == sorted(ids)
    for path, method, operation in operations(document):
        assert operation["summary"], (path, method)
        assert operation["description"], (path, method)


def test_every_error_is_a_problem_document(document: Json) -> None:
    for path, method, operation in operations(document):
        errors = {status: told for status, told in operation["responses"].items() if status >= "400"}
        for status, told in errors.items():
            assert told["content"] == {
                "application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}
            }, (path, method, status)
            assert told["description"]


def test_errors_are_named_where_they_can_happen(document: Json) -> None:
    for path, method, operation in operations(document):
        statuses = set(operation["responses"])
        if "requestBody" in operation:
            assert {"400", "413", "422"} <= statuses, (path, method)
        if "{id}" in path or "{robot}" in path:
            assert "404" in statuses, (path, method)
        if path.startswith("/v1"):
            assert "503" in statuses, (path, method)
        if any(parameter["name"] == "If-Match" for parameter in operation.get("parameters", [])):
            assert "412" in statuses, (path, method)


def test_every_write_to_a_session_takes_a_key_and_all_but_creation_an_if_match(document: Json) -> None:
    writes = {
        (path, method): {parameter["name"] for parameter in operation.get("parameters", [])}
        for path, method, operation in operations(document)
        if path.startswith("/v1/sessions") and method != "get" and not path.endswith("/voa")
    }
    assert len(writes) == 5
    for (path, _), names in writes.items():
        assert "Idempotency-Key" in names
        assert ("If-Match" in names) is (path != "/v1/sessions")


def test_references_lead_somewhere_and_parameters_stand_in_their_paths(document: Json) -> None:
    for node in nodes(document):
        reference = node.get("$ref")
        if isinstance(reference, str):
            assert reference.removeprefix("#/components/schemas/") in document["components"]["schemas"]
    for path, method, operation in operations(document):
        declared = {p["name"] for p in operation.get("parameters", []) if p["in"] == "path"}
        assert declared == set(re.findall(r"{(\w+)}", path)), (path, method)


def test_no_schema_is_left_over(document: Json) -> None:
    used = {node["$ref"].rpartition("/")[2] for node in nodes(document) if isinstance(node.get("$ref"), str)}
    assert used == set(document["components"]["schemas"])


@pytest.mark.parametrize(
    ("schema", "field", "word", "most"),
    [
        ("ScenarioRequest", "poses", "maxItems", 12),
        ("ScenarioRequest", "grasps", "maxItems", 14),
        ("ScenarioRequest", "sensors", "maxItems", 13),
        ("ScenarioRequest", "prior", "maxItems", 12),
        ("ScenarioRequest", "predictions", "maxItems", 11),
        ("Lidar", "beams", "maximum", 11),
        ("Scan", "ranges", "maxItems", 11),
        ("Scan", "no_return", "maxItems", 11),
        ("UpdateRequest", "belief", "maxItems", 12),
        ("BeliefRequest", "belief", "maxItems", 12),
        ("RankingRequest", "belief", "maxItems", 12),
        ("VoaRequest", "sensors", "maxItems", 13),
        ("VoaRequest", "grasps", "maxItems", 14),
        ("VoaRequest", "sensor_belief", "maxItems", 12),
        ("PredictionsRequest", "sensors", "maxItems", 13),
    ],
)
def test_limits_are_those_of_the_settings(document: Json, schema: str, field: str, word: str, most: int) -> None:
    found = {
        node[word] for node in nodes(document["components"]["schemas"][schema]["properties"][field]) if word in node
    }
    assert found == {most}


def test_no_mark_of_a_limit_is_left_in_the_document(document: Json) -> None:
    assert "x-limit" not in json.dumps(document)


def test_limits_default_to_those_of_the_contract(service: Service) -> None:
    schemas = service.get("/openapi.json")["components"]["schemas"]
    request = schemas["ScenarioRequest"]["properties"]
    assert [request[field]["maxItems"] for field in ("poses", "sensors", "grasps")] == [20_000, 4_096, 4_096]
    assert schemas["Scan"]["properties"]["ranges"]["maxItems"] == 4_096
    assert (Limits().faces, Limits().upload_bytes) == (200_000, 20_000_000)


def test_the_document_is_the_same_each_time_and_the_docs_show_it(service: Service) -> None:
    first = service.http.get("/openapi.json")
    assert service.http.get("/openapi.json").content == first.content
    docs = service.http.get("/docs")
    assert docs.status_code == 200
    assert "/openapi.json" in docs.text
